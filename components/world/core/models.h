// Models of a simulated chassis and of a simulated scanner, without a clock (specification,
// sections 10.1 and 10.3). Pure.
#pragma once

#include <chrono>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/motors.h"
#include "components/geometry/wheels.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"

namespace rack::sim {

// A chassis: limited speeds, reached immediately or, on request, with limited acceleration. In each
// period the speed changes towards its target, by accMax when it grows and by decMax when the
// vehicle brakes or reverses; the movement is this speed times the period.
class ChassisModel {
 public:
  // acceleration: whether accMax and decMax apply; the original ignores them.
  ChassisModel(const ChassisParamData& limits, bool acceleration);

  void set_active_pilot(tims::Address pilot);  // also stops
  [[nodiscard]] tims::Address active_pilot() const { return pilot_; }
  [[nodiscard]] const ChassisParamData& limits() const { return limits_; }
  // Limits the command to the range of the vehicle: a speed below the minimum becomes the minimum.
  void move(const ChassisMoveData& command) { wanted_ = device::within_limits(command, limits_); }

  // The movement during `period`.
  ChassisData step(TimeStamp now, std::chrono::milliseconds period);

 private:
  ChassisParamData limits_;
  device::Acceleration<float> acceleration_;
  device::ChassisSpeed wanted_;
  device::ChassisSpeed now_;
  tims::Address pilot_ = kNoPilot;
};

struct ScanSettings {
  i32 max_range = 10000;  // mm
  i32 first = -180;       // deg, of the robot
  i32 last = 180;
  i32 step = 1;

  [[nodiscard]] i32 count() const { return (last - first) / step + 1; }
};

// A scanner at the reference point of the robot. A ray is cast from the position of the robot in
// each direction of the scanner; its range is the distance to the first wall of a floor plan,
// without noise. A ray without a hit within the range of the scanner is invalid, as real scanners
// report it.
class ScanModel {
 public:
  // `settings`: step of at least 1, last not before first.
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
