// How motors follow their commands: speeds that change with limited acceleration, and the
// resulting position. How wheels then move a vehicle: wheels.h, and moved() in pose.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include "rack/proxies/chassis.h"

namespace rack::device {

// `from` after `seconds` of changing towards `to` by at most `rate` a second; 0: immediately.
template <std::floating_point Number>
Number towards(Number from, Number to, Number rate, Number seconds) {
  if (rate <= 0) return to;
  return from + std::clamp(to - from, -rate * seconds, rate * seconds);
}

// How much a speed can change in a second; 0: no limit.
template <std::floating_point Number>
struct Acceleration {
  Number faster = 0;
  Number slower = 0;  // while the motor brakes or reverses

  [[nodiscard]] Number changed(Number from, Number to, Number seconds) const {
    const bool brakes = std::abs(to) < std::abs(from) || to * from < 0;
    return towards(from, to, brakes ? slower : faster, seconds);
  }
};

inline Acceleration<float> acceleration_of(const ChassisParamData& limits) {
  return {.faster = static_cast<float>(limits.accMax.raw()),
          .slower = static_cast<float>(limits.decMax.raw())};
}

struct MotorMotion {
  double speed = 0;     // mm/s of the rim; of steering or a shaft rad/s
  double position = 0;  // mm of the rim since the start; of steering or a shaft its angle, rad

  void run(double target, const Acceleration<double>& limit, double seconds) {
    speed = limit.changed(speed, target, seconds);
    position += speed * seconds;
  }
  // At the speed `most`; 0: immediately.
  void go_to(double target, double most, double seconds) {
    const double before = position;
    position = towards(position, target, most, seconds);
    speed = (position - before) / seconds;
  }
};

}  // namespace rack::device
