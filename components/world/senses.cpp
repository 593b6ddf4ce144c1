#include "components/world/senses.h"

#include <algorithm>
#include <string>

namespace rack::device {
namespace {

using emulator::CoursePoint;
using emulator::Motion;
using tims::Errc;
using tims::Error;
using tims::Result;
using world::SensorKind;
using world::World;

constexpr double kMillimetres = 1000;  // per metre

CoursePoint course_point(const world::SatelliteFix& fix, Duration utc) {
  constexpr int kSatellites = 9;
  CoursePoint point;
  point.utc = utc;
  point.is_fixed = fix.is_valid;
  point.latitude = degrees(fix.latitude);
  point.longitude = degrees(fix.longitude);
  point.altitude = fix.altitude;
  point.course = degrees(heading(fix.course));
  point.speed = fix.speed / kMillimetres;
  point.satellites = fix.is_valid ? kSatellites : 2;
  return point;
}

// Converts x forward, y right, z down to x forward, y left, z up.
std::array<double, 3> upright(const std::array<double, 3>& values, double factor) {
  return {values[0] * factor, -values[1] * factor, -values[2] * factor};
}

Motion motion(const world::InertialMeasurement& felt) {
  return {.roll = felt.phi,
          .pitch = -felt.psi,
          .yaw = -signed_angle(felt.rho),
          .rates = upright(felt.rates, 1),
          .accelerations = upright(felt.accelerations, 1 / kMillimetres)};
}

}  // namespace

Scene scene_of(const World& world, const world::SensorId& sensor, Duration utc_of_zero) {
  const world::SensorDescription& its =
      world.description().robots[sensor.robot].sensors[sensor.sensor];
  const Duration lag = its.lag;
  Scene scene;
  scene.period = its.period;
  scene.sight = [&world, sensor, lag](double angle, double elevation, Time when) {
    const world::Echo echo =
        world.measure(sensor, {.azimuth = angle, .elevation = elevation}, when - lag);
    return echo.is_valid ? echo.range : emulator::kNothing;
  };
  scene.course = [&world, sensor, lag, utc_of_zero](Time when, Duration) {
    return course_point(world.satellite_fix(sensor, when - lag),
                        utc_of_zero + when.time_since_epoch());
  };
  scene.inertia = [&world, sensor, lag](Time when, Duration) {
    return motion(world.inertial(sensor, when - lag));
  };
  scene.heading = [&world, sensor, lag](Time when, Duration) {
    return degrees(heading(world.compass(sensor, when - lag)));
  };
  return scene;
}

Senses senses_of(SensorKind kind) {
  switch (kind) {
    case SensorKind::kScanner:
    case SensorKind::kScanner3d:
      return Senses::kSight;
    case SensorKind::kSatellite:
      return Senses::kCourse;
    case SensorKind::kInertial:
      return Senses::kInertia;
    case SensorKind::kCompass:
      return Senses::kHeading;
    case SensorKind::kCamera:
      return Senses::kPictures;
  }
  return Senses::kNothing;
}

Result<Drivetrain> Drivetrain::make(const World& world, std::size_t robot,
                                    emulator::Wheelwork& motors) {
  const world::RobotDescription& base = world.description().robots[robot];
  const Wheels& wheels = world.wheels(robot);
  if (motors.motor_count() != wheels.motors())
    return Error(Errc::kInvalidArgument, base.device + " has " +
                                             std::to_string(motors.motor_count()) +
                                             " motors, but the wheels of this robot need " +
                                             std::to_string(wheels.motors()));
  motors.set_lag(base.lag);
  Drivetrain train(robot, motors);
  train.count_ = motors.motor_count();
  for (std::size_t i = 0; i < train.count_; ++i) {
    Motor& motor = train.all_[i];
    motor.steers = wheels.is_steering(i);
    if (!motors.reports_shafts()) continue;
    motor.factor = motor.steers ? 1 / base.steer_ratio : base.wheel_radius / base.gear_ratio;
  }
  return train;
}

Result<Drivetrain> Drivetrain::make(const World& world, const world::SensorId& sensor,
                                    emulator::Wheelwork& motor) {
  const world::AxisDescription& axis =
      world.description().robots[sensor.robot].sensors[sensor.sensor].axis;
  if (motor.motor_count() != 1 || !motor.reports_shafts())
    return Error(Errc::kInvalidArgument, axis.device + " is not a drive of an axis");
  Drivetrain train(sensor.robot, motor);
  train.axis_ = sensor;
  train.count_ = 1;
  train.all_[0].factor = 1 / axis.gear_ratio;
  return train;
}

void Drivetrain::drive(World& world, Time now, Time next) {
  const double seconds = std::chrono::duration<double>(next - world.now()).count();
  if (seconds <= 0) return;
  std::array<double, world::kMotorsMax> positions{};
  motors_->turned(now, std::span(positions).first(count_));
  std::array<double, world::kMotorsMax> wanted{};
  const double since = std::chrono::duration<double>(now - asked_).count();
  const double ahead = std::chrono::duration<double>(next - now).count();
  for (std::size_t i = 0; i < count_; ++i) {
    Motor& motor = all_[i];
    const double position = positions[i] * motor.factor;
    const double rate = asked_ == Time{} || since <= 0 ? 0 : (position - motor.reported) / since;
    const double then = position + rate * ahead;
    wanted[i] = motor.steers ? then : (then - motor.driven) / seconds;
    motor.reported = position;
    motor.driven = then;
  }
  asked_ = now;
  if (axis_) return world.turn(*axis_, wanted[0]);
  // These motors have turned already, so the lag is included.
  const Duration lag = world.description().robots[robot_].lag;
  world.drive(robot_, std::span(wanted).first(count_), world.now() - lag);
}

void go_on(World& world, std::span<Drivetrain> trains, Time now, world::Truth& truth) {
  const Time here = world.now();
  if (now <= here) return;
  const auto steps = (now - here + world::kStep - Duration(1)) / world::kStep;
  const Time next = here + steps * world::kStep;
  for (Drivetrain& train : trains) train.drive(world, now, next);
  world.advance(next);
  world.truth(truth);
  for (Drivetrain& train : trains) train.touch(truth.robots[train.robot()].is_blocked);
}

}  // namespace rack::device
