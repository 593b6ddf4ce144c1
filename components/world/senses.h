// Connects the devices of a simulated world with the emulators: measurements of the world in the
// types of the emulators, with the lag of each sensor, and robots driven by emulated motors.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "components/devices/emulators/emulators.h"
#include "components/world/core/world.h"

namespace rack::device {

// The scene of a sensor, delayed by its lag. `utc_of_zero`: UTC when the host's clock was 0. The
// world must outlive the scene.
Scene scene_of(const world::World& world, const world::SensorId& sensor, Duration utc_of_zero);

// The senses that an emulator needs for a sensor of that kind.
Senses senses_of(world::SensorKind kind);

// The motors of a base and the wheels that they turn, or the motor of an axis. The wheels of the
// robot turn exactly as the emulated motors have turned: nothing is lost or added, however late
// this is called. The world is up to a step ahead of its motors; their speed is extrapolated until
// then, and the error is corrected in the next step. A steering angle is that of its motor.
class Drivetrain {
 public:
  // kInvalidArgument: the robot's wheels need a different number of motors.
  static tims::Result<Drivetrain> make(const world::World& world, std::size_t robot,
                                       emulator::Wheelwork& motors);

  // For the axis that turns a sensor: one motor, which reports its shaft.
  static tims::Result<Drivetrain> make(const world::World& world, const world::SensorId& sensor,
                                       emulator::Wheelwork& motor);

  // Call before the world advances to `next`, in steps from its current time, which is before
  // `now`.
  void drive(world::World& world, Time now, Time next);
  // Sets the state of the bumpers; an axis has none.
  void touch(bool is_touching) {
    if (!axis_) motors_->touch(is_touching);
  }
  [[nodiscard]] std::size_t robot() const { return robot_; }

 private:
  Drivetrain(std::size_t robot, emulator::Wheelwork& motors) : robot_(robot), motors_(&motors) {}

  // Conversion of a motor's unit to mm of the rim, or rad of the steering.
  struct Motor {
    double factor = 1;
    bool steers = false;
    double reported = 0;  // its position at the last query
    double driven = 0;    // the part that the world has driven
  };

  std::size_t robot_;
  emulator::Wheelwork* motors_;
  std::optional<world::SensorId> axis_{};  // instead of the robot's wheels
  std::size_t count_ = 0;
  Time asked_{};
  std::array<Motor, world::kMotorsMax> all_{};
};

// Advances the world to `now`, or up to a step beyond, as its motors have turned. `truth`: the
// state then.
void go_on(world::World& world, std::span<Drivetrain> trains, Time now, world::Truth& truth);

}  // namespace rack::device
