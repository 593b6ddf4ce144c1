// The environment of emulated devices. Each emulator has a small built-in scene, for example a room
// or a circular course, which can be replaced, for example by a simulated world. `when` is the time
// of the measurement, which may be some turns of a scanner in the past. The scene determines only
// the measured values, not the timing of the device.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "rack/devices/dialogue.h"

namespace rack::device::emulator {

// For range finders: distance along a ray, mm; kNothing or more if the ray hits nothing. `angle` is
// clockwise from straight ahead and `elevation` upwards from the scan plane, rad, both relative to
// the mounted device.
using Sight = std::function<double(double angle, double elevation, Time when)>;
inline constexpr double kNothing = 1e9;

// Position and velocity of a satellite receiver.
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

// State of an inertial sensor, label up: x ahead, y to the left, z up, all angles right-handed.
struct Motion {
  double roll = 0;  // rad
  double pitch = 0;
  double yaw = 0;
  std::array<double, 3> rates{};          // rad/s about x, y, z
  std::array<double, 3> accelerations{};  // m/s2; at rest gravity, upwards
};
using Inertia = std::function<Motion(Time when, Duration since_start)>;

// Heading of a compass, deg clockwise from north.
using Heading = std::function<double(Time when, Duration since_start)>;

// The pictures of a camera, as JPEG. Making one takes longer than a device may block: it is
// ordered, and taken when it is ready.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  [[nodiscard]] virtual Duration period() const = 0;  // between pictures
  // A picture of this moment. No effect while the previous one is being made.
  virtual void order(Time when) = 0;
  // The picture ordered last, once: true if it was ready and replaced `jpeg`.
  virtual bool take(std::vector<std::byte>& jpeg) = 0;
};

// The drive train of a vehicle: how far its motors have turned since power-on. Motors keep running
// without a connection, so this is also called while the vehicle is unplugged.
class Wheelwork {
 public:
  virtual ~Wheelwork() = default;
  [[nodiscard]] virtual std::size_t motor_count() const = 0;
  // For all motors: distance at the rim, mm (left, right), or angle of the shaft, rad, where the
  // gear ratio is configurable.
  virtual void turned(Time now, std::span<double> positions) = 0;
  // True: turned() returns shaft angles; gears and wheels belong to the vehicle.
  [[nodiscard]] virtual bool reports_shafts() const { return false; }
  // Delay until motors execute a command. Encoders report the actual motion.
  virtual void set_lag(Duration lag) = 0;
  // The vehicle touches an obstacle: for its bumpers.
  virtual void touch(bool /*is_touching*/) {}
};

}  // namespace rack::device::emulator
