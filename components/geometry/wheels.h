// Wheel kinematics: the targets of wheels and steering for a movement of the vehicle, and the
// movement that results from its wheels. In the vehicle's frame: x forward, y to the right, angles
// clockwise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rack/proxies/chassis.h"

namespace rack::device {

struct ChassisSpeed {
  float vx = 0;     // mm/s, forward
  float vy = 0;     // mm/s, to the right
  float omega = 0;  // rad/s, clockwise

  bool operator==(const ChassisSpeed&) const = default;
};

// A command within the limits of a vehicle: no speed above its maximum, or below its minimum except
// 0; without a turning speed that is not a number.
ChassisSpeed within_limits(const ChassisMoveData& command, const ChassisParamData& limits);

struct Wheel {
  double x = 0;  // mm, from the reference point
  double y = 0;
  int drive = -1;  // index of the motor that drives it; -1: none
  int steer = -1;  // index of the motor that steers it; -1: not steered
};

class Wheels {
 public:
  // steer_max: rad to each side.
  Wheels(std::vector<Wheel> wheels, std::size_t motors, double steer_max)
      : wheels_(std::move(wheels)), motors_(motors), steer_max_(steer_max) {}

  // Two wheels on one axle: motors 0 left, 1 right.
  static Wheels differential(double track);
  // Rear axle driven, front axle steered; the reference point is on the rear axle. Motors: 0 left,
  // 1 right, 2 steers; with one rear motor: 0 drives, 1 steers.
  static Wheels ackermann(double base, double track, bool one_motor, double steer_max);
  // Both axles steered, four wheels driven; the reference point is in the middle. Motors: 0 front
  // left, 1 front right, 2 rear left, 3 rear right, 4 steers the front, 5 the rear.
  static Wheels double_ackermann(double base, double track, double steer_max);

  [[nodiscard]] std::size_t motors() const { return motors_; }
  [[nodiscard]] bool is_steering(std::size_t motor) const;

  // The target of each motor: mm/s of the rim, or rad (clockwise) of the steering; for speed 0 the
  // steering keeps its angle.
  void targets(const ChassisSpeed& speed, std::span<double> motors) const;
  // The movement that fits best (least squares) to rims (mm/s, or mm) and steering.
  [[nodiscard]] ChassisSpeed movement(std::span<const double> motors) const;

 private:
  std::vector<Wheel> wheels_;
  std::size_t motors_;
  double steer_max_;
};

}  // namespace rack::device
