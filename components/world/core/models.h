// What a robot that is not there does and sees: the models of a chassis and of a scanner, without a
// clock (specification, sections 10.1 and 10.3). Pure.
#pragma once

#include <chrono>
#include <vector>

#include "components/geometry/floor_map.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"

namespace rack::sim {

// A vehicle that does what it is told: speeds within limits, reached at once or, when wanted, at
// the acceleration it has. Once a period the speed takes a step towards the one that is wanted, by
// accMax when it grows and by decMax when the vehicle brakes or turns round; what it has moved is
// this speed times the period.
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

struct ScanSettings {
  i32 max_range = 10000;  // mm
  i32 first = -180;       // deg, of the robot
  i32 last = 180;
  i32 step = 1;

  [[nodiscard]] i32 count() const { return (last - first) / step + 1; }
};

// What a scanner in the middle of the robot would see of a floor plan. From the place of the robot
// a ray is cast into each direction of the scanner, and its way to the first wall is the distance
// that is measured, without noise; a ray that meets none within the range of the scanner is
// invalid, as a real scanner says it.
class ScanModel {
 public:
  // settings: step of 1 and more, last not before first.
  ScanModel(FloorMap map, const ScanSettings& settings);

  void measure(const OdometryData& from, std::chrono::milliseconds duration, LadarData& scan);
  void measure(const OdometryData& from, std::chrono::milliseconds duration, Scan2dData& scan);

 private:
  void cast(const OdometryData& from);
  [[nodiscard]] double angle(std::size_t ray) const;

  FloorMap map_;
  ScanSettings settings_;
  std::vector<double> ranges_;
};

}  // namespace rack::sim
