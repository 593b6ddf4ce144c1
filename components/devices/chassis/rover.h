// Emulator of a rover with an autopilot: heartbeat, attitude, local position, GPS, battery. It
// drives when it is armed, and stops after three seconds without a velocity.
#pragma once

#include "components/devices/chassis/mavlink.h"
#include "components/devices/chassis/wheeled_model.h"

namespace rack::device {

class RoverEmulator final : public WheeledRobot {
 public:
  static constexpr std::uint8_t kSystem = 3;
  static constexpr Duration kVelocityTimeout = std::chrono::seconds(3);
  static constexpr std::uint32_t kGuided = 15;

  RoverEmulator() : WheeledRobot(WheeledModel{500, 2000}) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] bool is_armed() const { return armed_; }
  // Number of interval requests received.
  [[nodiscard]] int intervals() const { return intervals_; }
  bool sends_odometry = false;

 private:
  void on_packet(const mavlink::Packet& packet, Time now, Output& out);
  void send_status(Output& out);
  void send_motion(Time now, Output& out);
  mavlink::Writer writer(mavlink::Message message) { return {message, sequence_++, kSystem, 1}; }

  mavlink::Packets packets_;
  mavlink::Packet packet_;
  std::uint8_t sequence_ = 0;
  bool armed_ = false;
  std::uint32_t mode_ = 0;
  int intervals_ = 0;
  int tick_ = 0;
  Time commanded_{};
  Time next_ = tims::kNever;
};

}  // namespace rack::device
