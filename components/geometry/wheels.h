// Where the wheels of a vehicle are, what they have to do for a speed of it, and what the vehicle
// does when its wheels do something. In the vehicle's frame: x forward, y to the right, turning
// clockwise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace rack::device {

struct ChassisSpeed {
  float vx = 0;     // mm/s, forward
  float vy = 0;     // mm/s, to the right
  float omega = 0;  // rad/s, clockwise

  bool operator==(const ChassisSpeed&) const = default;
};

struct Wheel {
  double x = 0;  // mm, from the reference point
  double y = 0;
  int drive = -1;  // number of the motor that turns it; -1: none
  int steer = -1;  // number of the motor that steers it; -1: it is fixed
};

class Wheels {
 public:
  // steer_max: rad to each side.
  Wheels(std::vector<Wheel> wheels, std::size_t motors, double steer_max)
      : wheels_(std::move(wheels)), motors_(motors), steer_max_(steer_max) {}

  // Two wheels beside each other: motors 0 left, 1 right.
  static Wheels differential(double track);
  // Driven behind, steered before; the reference point is the rear axle. Motors: 0 left, 1 right, 2
  // steers; with one motor behind: 0 drives, 1 steers.
  static Wheels ackermann(double base, double track, bool one_motor, double steer_max);
  // Both axles are steered, four wheels are driven; the reference point is the middle. Motors: 0
  // front left, 1 front right, 2 rear left, 3 rear right, 4 steers the front, 5 the rear.
  static Wheels double_ackermann(double base, double track, double steer_max);

  [[nodiscard]] std::size_t motors() const { return motors_; }
  [[nodiscard]] bool is_steering(std::size_t motor) const;

  // Of each motor: mm/s of the rim, or rad (clockwise) of the steering; steering stays where it was
  // when the vehicle shall stand.
  void targets(const ChassisSpeed& speed, std::span<double> motors) const;
  // The movement that fits best (least squares) to that of the rims (mm/s, or mm) and the steering.
  [[nodiscard]] ChassisSpeed movement(std::span<const double> motors) const;

 private:
  std::vector<Wheel> wheels_;
  std::size_t motors_;
  double steer_max_;
};

}  // namespace rack::device
