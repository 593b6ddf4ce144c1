// A robot's motors and wheels: what they are told comes after a lag, they follow as fast as they
// can, and the ground takes what they do with some slip. What the wheels do to the robot is
// Wheels' business, as for the drivers; only here the ground has a part in it. (WheeledModel and
// ShaftModel in components/devices/chassis are what such a device shows on its line; they stand
// without a ground.)
#pragma once

#include <array>
#include <span>

#include "components/geometry/delay.h"
#include "components/geometry/random.h"
#include "components/world/core/world.h"

namespace rack::world {

// In the frame of the robot, within a step.
struct Movement {
  double x = 0;    // mm
  double y = 0;    // mm
  double rho = 0;  // rad
};

class Vehicle {
 public:
  Vehicle(const RobotDescription& robot, std::uint64_t seed);

  [[nodiscard]] const device::Wheels& wheels() const { return wheels_; }
  // Those of motors that are left out, and what is no number, stay.
  void drive(std::span<const double> motors, tims::Time due);
  void drive(const device::ChassisSpeed& speed, tims::Time due);
  // What it does over ground in the step that begins then.
  Movement step(tims::Time begin);
  // What it was told is forgotten, and its wheels stand.
  void stop();

  [[nodiscard]] std::span<const MotorState> motors() const {
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
  std::array<MotorState, kMotorsMax> motors_{};
  Targets targets_{};  // what the motors know of
  device::Delay<Targets> under_way_;
};

}  // namespace rack::world
