// A vehicle with motor controllers on a CAN bus: differential, or steered on one or both axles.
// Commands are sent only when all motors are ready; the failure of one motor stops all.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "components/devices/chassis/chassis_control.h"
#include "components/devices/chassis/cia402.h"
#include "components/devices/chassis/motor.h"
#include "components/geometry/wheels.h"

namespace rack::device {

struct MotorLink {
  std::unique_ptr<Motor> motor{};
  std::string name{};  // "left motor (node 3)"
  // rad of the motor's shaft per mm at the rim, or per rad of the steering; below 0: reversed.
  double gear = 1;
  double zero = 0;  // steering: rad of the motor for straight ahead
};

struct MotorChassisSettings {
  Duration cycle = std::chrono::milliseconds(20);    // period of the commands
  Duration period = std::chrono::milliseconds(100);  // period of the data
  bool is_canopen = false;                           // send heartbeat and SYNC
  bool only_listen = false;                          // the device is a recording
};

class MotorChassis final : public ChassisDialogue {
 public:
  // One link for each motor of the wheels.
  MotorChassis(const MotorChassisSettings& settings, Wheels wheels, std::vector<MotorLink> links);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> stop_commands() const override;
  [[nodiscard]] Time next_timeout() const override;
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override;

  void drive(const ChassisSpeed& speed, Time now) override;
  [[nodiscard]] bool is_ready() const override { return is_ready_; }
  bool take(ChassisData& data, Time& recorded) override;

 private:
  void check(Time now, Output& out);
  void command_all(Time now, Output& out);
  void measure(Time now);

  MotorChassisSettings settings_;
  Wheels wheels_;
  std::vector<MotorLink> links_;
  canopen::Host host_;
  bool is_ready_ = false;
  bool is_stopped_ = true;
  Time ready_due_ = tims::kNever;
  Time next_cycle_ = tims::kNever;
  Time last_cycle_{};
  Time next_data_ = tims::kNever;

  ChassisSpeed wanted_;
  std::vector<double> targets_;    // targets of the wheels
  std::vector<double> positions_;  // positions of the rims at the last data, mm
  std::vector<double> measured_;
  bool has_data_ = false;
  ChassisData data_;
  Time recorded_{};
};

}  // namespace rack::device
