// What emulated devices sense around them. Each of them has a small scene of its own, a room or a
// circle, and takes another one in its place: that of a simulated world, for example. `when` is the
// time of the measurement, which may lie some turns of a scanner back; what a device does, it does
// as often as it did without: the scene only says what it would measure.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "components/devices/core/dialogue.h"

namespace rack::device::emulator {

// Of a range finder: how far it is along a ray, mm; kNothing and more: it meets nothing. The ray:
// rad clockwise from ahead, and up from its plane, as the device is mounted.
using Sight = std::function<double(double angle, double elevation, Time when)>;
inline constexpr double kNothing = 1e9;

// Where a satellite receiver is, and how it moves.
struct CoursePoint {
  Duration utc{};  // since 1970
  bool is_fixed = false;
  double latitude = 0;   // deg
  double longitude = 0;  // deg
  double altitude = 0;   // m
  double course = 0;     // deg, 0: north
  double speed = 0;      // m/s
  int satellites = 0;
};
using Course = std::function<CoursePoint(Time when, Duration since_start)>;

// What an inertial sensor feels, label up: x ahead, y to the left, z up, all angles right-handed.
struct Motion {
  double roll = 0;  // rad
  double pitch = 0;
  double yaw = 0;
  std::array<double, 3> rates{};          // rad/s about x, y, z
  std::array<double, 3> accelerations{};  // m/s2; at rest gravity, upwards
};
using Inertia = std::function<Motion(Time when, Duration since_start)>;

// Where a compass points, deg clockwise from north.
using Heading = std::function<double(Time when, Duration since_start)>;

// A base, seen from its wheels: what its motors have turned since it was switched on. Motors run on
// while nobody talks with it, so this is asked at any time, also of one that is unplugged.
class Wheelwork {
 public:
  virtual ~Wheelwork() = default;
  [[nodiscard]] virtual std::size_t motor_count() const = 0;
  // Of all motors: mm of the rim (left, right), or rad of the shafts where these can have any gear.
  virtual void turned(Time now, std::span<double> ways) = 0;
  // The second: gears and wheels are those of the vehicle that the motors are built into.
  [[nodiscard]] virtual bool tells_shafts() const { return false; }
  // Motors begin so much later what they are told; what their encoders say is what they do.
  virtual void set_lag(Duration lag) = 0;
  // It drives against something: for its bumpers.
  virtual void touch(bool /*is_touching*/) {}
};

}  // namespace rack::device::emulator
