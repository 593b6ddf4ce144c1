// The motors and wheels of a robot: commands take effect after a lag, motors follow within their
// limits, and the ground adds slip. The kinematics is that of Wheels, which the drivers also use.
#pragma once

#include <array>
#include <span>

#include "components/geometry/delay.h"
#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/world/core/world.h"

namespace rack::world {

class Vehicle {
 public:
  Vehicle(const RobotDescription& robot, std::uint64_t seed);

  [[nodiscard]] const device::Wheels& wheels() const { return wheels_; }
  // Motors without a value, or with one that is not a number, keep their target.
  void drive(std::span<const double> motors, tims::Time due);
  void drive(const device::ChassisSpeed& speed, tims::Time due);
  // The movement over ground in the step that begins at `begin`.
  Movement step(tims::Time begin);
  // Drops all commands and stops the wheels.
  void stop();

  [[nodiscard]] std::span<const device::MotorMotion> motors() const {
    return std::span(motors_).first(wheels_.motors());
  }

 private:
  using Targets = std::array<double, kMotorsMax>;

  [[nodiscard]] const Targets& newest() const;
  void follow(std::size_t motor);
  [[nodiscard]] Movement on_ground(Movement movement);

  RobotDescription limits_;
  device::Wheels wheels_;
  Random random_;
  std::array<device::MotorMotion, kMotorsMax> motors_{};
  Targets targets_{};  // commands that have reached the motors
  device::Delay<Targets> in_flight_;
};

}  // namespace rack::world
