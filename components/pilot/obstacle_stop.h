// Limits the speed of a vehicle along its path, so that it stops before it touches an obstacle seen
// by the scanner. Pure.
//
// Each point of a scan is converted to a distance along the path and a distance beside it, as if
// the path were straight (the original also straightens scans, but along a single arc). Then the
// rules for a straight path apply. drive.h derives the speed from the free distance by the
// vehicle's break constant, for comfort. The physical limit is added: the vehicle continues during
// the reaction time and then brakes with decMax, so v t + v^2 / 2a must not exceed the free
// distance. The same check is made for the arc that the vehicle currently drives, in case it is not
// on its path. The hull is widened by the vehicle's offset from the path, and on the outside of a
// bend by the swing of its front. What stands still beside the path, a little within the safety
// margin, is passed slowly: a vehicle that stops there never leaves.
#pragma once

#include <chrono>
#include <span>

#include "components/pilot/path_follower.h"
#include "rack/proxies/scan2d.h"
#include "tims/result.h"

namespace rack::pilot {

// Checks that a vehicle stops within the distance that its break constant allows. The error states
// values that would be safe.
tims::Result<void> check_braking(const ChassisParamData& chassis, double speed_max,
                                 std::chrono::milliseconds reaction);

class ObstacleStop {
 public:
  // reaction: time from when an obstacle is visible until the vehicle brakes.
  ObstacleStop(const ChassisParamData& chassis, std::chrono::milliseconds reaction);

  // mm/s, not negative. `seen_from`: pose of the vehicle at the scan. While the vehicle is held,
  // the margins are doubled.
  double speed_max(const Scan2dData& scan, const Pose& seen_from, const Pose& at,
                   const PathFollower& follower);

  // Whether a vehicle at rest may turn with this angular speed: its corners swing out, and must not
  // come closer to an obstacle than the safety margin; than kTurnMargin to one that is within it.
  [[nodiscard]] bool may_turn(const Scan2dData& scan, const Pose& seen_from, const Pose& at,
                              double omega) const;
  static constexpr double kTurnMargin = 40;  // mm

  // mm, to the nearest obstacle ahead at the last call; limited to the look-ahead distance.
  [[nodiscard]] double free_distance() const { return free_distance_; }

 private:
  struct Course {
    std::span<const PolarSpline> splines;
    double from = 0;  // start on the first of them, mm
    double left = 0;  // widening of the hull, mm
    double right = 0;
    double end = 0;  // end of the path, measured from the vehicle, mm
  };
  [[nodiscard]] bool straighten(const ScanPoint& point, const Pose& seen_from, const Course& course,
                                ScanPoint& straight) const;
  double limit(const Scan2dData& scan, const Pose& seen_from, const Course& course, bool comfort);
  [[nodiscard]] double still_stops(double free) const;
  [[nodiscard]] double hull_ahead() const;
  [[nodiscard]] double clearance(const Pose& point) const;

  ChassisParamData chassis_;
  ChassisParamData margins_;  // with the margins of this call
  double reaction_;           // s
  double look_ahead_;         // mm
  double sense_ = 1;
  double free_distance_ = 0;
};

}  // namespace rack::pilot
