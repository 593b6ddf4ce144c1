// One axis with a CiA 402 drive: a pan unit, a turntable, a lift.
#pragma once

#include <utility>

#include "components/devices/chassis/cia402.h"
#include "components/devices/chassis/move_deadline.h"
#include "rack/proxies/servo_drive.h"

namespace rack::device {

struct ServoAxisSettings {
  Cia402Settings drive{};
  double gear = 1;  // rad of the motor per rad or mm of the axis; below 0: reversed
  // Permitted range, rad or mm.
  double min = -1e9;
  double max = 1e9;
  double velocity_max = 1;  // rad/s or mm/s
  Duration period = std::chrono::milliseconds(50);
  Duration move_deadline{};  // validity of move(); 0: three periods of the caller
  bool only_listen = false;  // the device is a recording
};

// Interpolates linearly between two data sets.
ServoDriveData interpolated(const ServoDriveData& before, const ServoDriveData& after,
                            TimeStamp time);

class ServoAxis final : public Dialogue {
 public:
  explicit ServoAxis(const ServoAxisSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> stop_commands() const override;
  [[nodiscard]] Time next_timeout() const override;
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override;

  // velocity, acceleration: limits; 0: maximum.
  void move_to(double position, double velocity, double acceleration);
  // Moves until the end of the range, or until the command expires without a repetition
  // (move_deadline.h). 0: stops.
  void move(double velocity, Time now);
  // True once after each stop because the command had expired.
  bool take_overdue() { return std::exchange(overdue_, false); }
  // Starts homing: the homing method determines position 0.
  void home();

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  // The target is reached.
  [[nodiscard]] bool is_reached() const;
  bool take(ServoDriveData& data, Time& recorded);

 private:
  void check(Time now, Output& out);
  void command(Time now, Output& out);
  [[nodiscard]] double position() const { return drive_.state().position / settings_.gear; }

  ServoAxisSettings settings_;
  Cia402 drive_;
  canopen::Host host_;
  bool is_ready_ = false;
  bool is_stopped_ = true;
  Time next_cycle_ = tims::kNever;
  Time next_data_ = tims::kNever;
  MoveDeadline deadline_;
  bool overdue_ = false;
  double target_ = 0;  // rad or mm
  double velocity_ = 0;
  double acceleration_ = 0;
  bool has_limits_ = false;  // new limits must be sent
  bool shall_home_ = false;
  bool has_data_ = false;
  Time recorded_{};
};

}  // namespace rack::device
