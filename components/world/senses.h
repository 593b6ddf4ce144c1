// What the devices of a simulated world sense and do: the world's answers in the words of the
// emulators, with the lag of each sensor, and its robots driven by what emulated motors turn.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "components/devices/emulators/emulators.h"
#include "components/world/core/world.h"

namespace rack::device {

// Of that sensor: as late as its description says. `utc_of_zero`: the clock on the wall when the
// host's clock was 0. The world must outlive whatever is made with it.
Scene scene_of(const world::World& world, const world::SensorId& sensor, Duration utc_of_zero);

// What an emulator has to sense for a sensor of that kind.
Senses senses_of(world::SensorKind kind);

// The motors of a base, and the wheels they turn, or the motor of an axis. What an emulated motor
// has turned, the robot's wheels have turned as well: nothing is lost or added, however late this
// is asked. The world is up to a step ahead of its motors; they are taken to run on until then as
// they did, and what was taken wrongly is made up for by the next step. Steering stands where its
// motor stands.
class Drivetrain {
 public:
  // kInvalidArgument: the robot's wheels need another number of motors.
  static tims::Result<Drivetrain> make(const world::World& world, std::size_t robot,
                                       emulator::Wheelwork& motors);

  // Of the axis that turns a sensor: one motor, which tells its shaft.
  static tims::Result<Drivetrain> make(const world::World& world, const world::SensorId& sensor,
                                       emulator::Wheelwork& motor);

  // Before the world goes on to `next`, in steps from where it is, which is before `now`.
  void drive(world::World& world, Time now, Time next);
  // Its bumpers; an axis has none.
  void touch(bool is_touching) {
    if (!axis_) motors_->touch(is_touching);
  }
  [[nodiscard]] std::size_t robot() const { return robot_; }

 private:
  Drivetrain(std::size_t robot, emulator::Wheelwork& motors) : robot_(robot), motors_(&motors) {}

  // mm of the rim, or rad of the steering, for each unit that the motor tells.
  struct Motor {
    double factor = 1;
    bool steers = false;
    double told = 0;    // its way when it was asked last
    double driven = 0;  // what the world has driven of it
  };

  std::size_t robot_;
  emulator::Wheelwork* motors_;
  std::optional<world::SensorId> axis_{};  // in place of the robot's wheels
  std::size_t count_ = 0;
  Time asked_{};
  std::array<Motor, world::kMotorsMax> all_{};
};

// The world until now, or a step beyond, as its motors have turned. `truth`: what is true then.
void go_on(world::World& world, std::span<Drivetrain> trains, Time now, world::Truth& truth);

}  // namespace rack::device
