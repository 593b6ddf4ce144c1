// A scan as those look at it who search for objects: where each beam ended, in the frame of the
// map or of the odometry, and how far it is free where a beam met nothing. Pure.
#pragma once

#include <vector>

#include "components/geometry/pose.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

struct Sight {
  double x = 0;  // mm, where the beam ended
  double y = 0;
  float local_x = 0;  // mm, as the robot sees it
  float local_y = 0;
  double away = 0;         // mm, from the scanner
  bool hit = false;        // else it met nothing as far as the scanner sees
  bool explained = false;  // by the map
  bool moved = false;      // earlier scans have looked through this place
  double stood = 0;        // s: so long ago an earlier scan has met something here, too
};

class ScanView {
 public:
  ScanView();

  // `scanner`: on the robot. Left out is what is no measurement; what is farther than range_max
  // counts as nothing there. Sorted by angle.
  void take(const Scan2dData& scan, const Pose& scanner, double range_max);
  // Where the robot was then: from now on sights have their places.
  void place(const Pose& robot);

  [[nodiscard]] const std::vector<Sight>& sights() const { return sights_; }
  std::vector<Sight>& sights() { return sights_; }
  // As of the last place().
  [[nodiscard]] const Pose& scanner() const { return scanner_; }
  [[nodiscard]] const Pose& mounting() const { return mounting_; }
  // rad between two beams.
  [[nodiscard]] double resolution() const { return resolution_; }
  // The last beam is beside the first one.
  [[nodiscard]] bool full_turn() const { return full_turn_; }
  // mm between two beams where they are so far away.
  [[nodiscard]] double spacing(double away) const { return away * resolution_; }

 private:
  struct Beam {
    double angle;  // as the scanner sees it
    Sight sight;
  };
  std::vector<Beam> beams_;
  std::vector<Sight> sights_;
  Pose mounting_{};
  Pose scanner_{};
  double resolution_ = 0;
  bool full_turn_ = false;
};

}  // namespace rack::perception
