// How fast a vehicle may go along its path among what a scan sees, so that it comes to rest before
// it touches anything. Pure.
//
// Each point of a scan is said as a way along the path and a distance beside it: as if the path
// were straight (the original straightens scans, too, but along one arc). There the rules of a
// straight way hold: drive.h gives the speed for the way that is free by the vehicle's break
// constant, which is comfort; beside it stands physics: in the time of reaction it goes on, then it
// brakes with decMax, v t + v^2 / 2a, and that must not be more than the free way. The same is
// asked of the arc that the vehicle is on at the moment, in case it is not on its path. The hull is
// as wide as it is, wider by how far it is beside the path, and on the outside of a bend by how far
// its front swings out.
#pragma once

#include <chrono>
#include <span>

#include "components/pilot/path_follower.h"
#include "rack/proxies/scan2d.h"
#include "tims/result.h"

namespace rack::pilot {

// Whether a vehicle stops within the way of its break constant. The error says what would do.
tims::Result<void> check_braking(const ChassisParamData& chassis, double speed_max,
                                 std::chrono::milliseconds reaction);

class ObstacleStop {
 public:
  // reaction: from when something can be seen to when the vehicle brakes.
  ObstacleStop(const ChassisParamData& chassis, std::chrono::milliseconds reaction);

  // mm/s, not negative. `seen_from`: where the vehicle was when it made the scan. While it holds,
  // the margins are twice as wide.
  double speed_max(const Scan2dData& scan, const Pose& seen_from, const Pose& at,
                   const PathFollower& follower);

  // mm, to what is in the way, at the last call; no more than it looks.
  [[nodiscard]] double free_way() const { return free_way_; }

 private:
  struct Way {
    std::span<const PolarSpline> splines;
    double from = 0;  // on the first of them, mm
    double left = 0;  // how much wider the hull is, mm
    double right = 0;
    double end = 0;  // where it stops, seen from the vehicle, mm
  };
  [[nodiscard]] bool straighten(const ScanPoint& point, const Pose& seen_from, const Way& way,
                                ScanPoint& straight) const;
  double limit(const Scan2dData& scan, const Pose& seen_from, const Way& way, bool comfort);
  [[nodiscard]] double still_stops(double free) const;
  [[nodiscard]] double hull_ahead() const;

  ChassisParamData chassis_;
  ChassisParamData margins_;  // with those of this call
  double reaction_;           // s
  double look_ahead_;         // mm
  double sense_ = 1;
  double free_way_ = 0;
};

}  // namespace rack::pilot
