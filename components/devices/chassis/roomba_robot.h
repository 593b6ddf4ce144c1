// Emulator of a Roomba or Create 2. As the real robots, it keeps driving until a stop command.
#pragma once

#include "components/devices/chassis/roomba.h"
#include "components/devices/chassis/wheeled_model.h"

namespace rack::device {

class RoombaEmulator final : public WheeledRobot {
 public:
  explicit RoombaEmulator(RoombaModel model)
      : WheeledRobot(WheeledModel(model == RoombaModel::kRoomba ? 258 : 235, 2000)),
        model_(model) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_frame_; }

  void touch(bool is_touching) override { bumps = is_touching ? 3 : 0; }

  [[nodiscard]] int motors() const { return motors_; }
  [[nodiscard]] bool is_in_control() const { return in_control_; }
  std::uint8_t bumps = 0;  // reported bumper state
  std::uint8_t overcurrents = 0;

 private:
  void on_command(std::span<const std::byte> bytes, Time now, Output& out);
  void send_sensors(Output& out);
  void send_frame(Output& out);

  RoombaModel model_;
  StreamBuffer received_{256};
  bool started_ = false;
  bool in_control_ = false;  // not passive: it obeys DRIVE and MOTORS
  int motors_ = 0;
  double reported_left_ = 0;  // distance reported so far, mm
  double reported_right_ = 0;
  Time next_frame_ = tims::kNever;
};

}  // namespace rack::device
