// A vehicle that does what it is told: speeds within limits, reached at once or, when wanted, at
// the acceleration it has (specification, section 10.1). Pure.
//
// Once a period the speed takes a step towards the one that is wanted, by accMax when it grows and
// by decMax when the vehicle brakes or turns round; what it has moved is this speed times the
// period.
#pragma once

#include <chrono>

#include "rack/proxies/chassis.h"

namespace rack::sim {

class ChassisModel {
 public:
  // acceleration: whether accMax and decMax count; the original leaves them out.
  ChassisModel(const ChassisParamData& limits, bool acceleration);

  void set_active_pilot(tims::Address pilot);  // also stops
  [[nodiscard]] tims::Address active_pilot() const { return pilot_; }
  [[nodiscard]] const ChassisParamData& limits() const { return limits_; }
  // The wish is cut to what the vehicle can do: a speed below the smallest becomes the smallest.
  void move(const ChassisMoveData& wish);

  // What it has done in `period`.
  ChassisData step(TimeStamp now, std::chrono::milliseconds period);

 private:
  struct Speed {
    float vx = 0;     // mm/s
    float vy = 0;     // mm/s
    float omega = 0;  // rad/s
  };
  [[nodiscard]] float approach(float from, float to, float seconds) const;

  ChassisParamData limits_;
  bool acceleration_;
  Speed wanted_;
  Speed now_;
  tims::Address pilot_ = kNoPilot;
};

}  // namespace rack::sim
