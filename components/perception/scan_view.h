// A scan prepared for object detection: the end points of the beams in the frame of the map or of
// the odometry, and the free distance where a beam hit nothing. Pure.
#pragma once

#include <vector>

#include "components/geometry/pose.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

struct Sight {
  double x = 0;  // mm, end point of the beam
  double y = 0;
  float local_x = 0;  // mm, in the frame of the robot
  float local_y = 0;
  double away = 0;         // mm, from the scanner
  bool hit = false;        // false: no hit within the scanner's range
  bool explained = false;  // by the map
  bool moved = false;      // earlier scans saw through this place
  double stood = 0;        // s: age of the oldest scan that hit something here, too
};

class ScanView {
 public:
  ScanView();

  // `scanner`: on the robot. Invalid points are ignored; a hit farther than range_max counts as
  // none. Sorts by angle.
  void take(const Scan2dData& scan, const Pose& scanner, double range_max);
  // Sets the pose of the robot at the scan, and from it the positions of all sights.
  void place(const Pose& robot);

  [[nodiscard]] const std::vector<Sight>& sights() const { return sights_; }
  std::vector<Sight>& sights() { return sights_; }
  // Pose of the scanner at the last place().
  [[nodiscard]] const Pose& scanner() const { return scanner_; }
  [[nodiscard]] const Pose& mounting() const { return mounting_; }
  // rad between two beams.
  [[nodiscard]] double resolution() const { return resolution_; }
  // The scan covers 360 degrees: the last beam is adjacent to the first.
  [[nodiscard]] bool full_turn() const { return full_turn_; }
  // mm between two beams at the distance `away`.
  [[nodiscard]] double spacing(double away) const { return away * resolution_; }

 private:
  struct Beam {
    double angle;  // in the frame of the scanner
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
