// Merges the scans of several scanners into one, as if it had been taken at one moment
// (specification, section 10.4). Pure.
//
// Scanners are not synchronised, and the robot moves between their scans. Each scan is therefore
// stored in the frame of the odometry, at the pose of the scan's own time; the merged scan contains
// the newest scan of each scanner, transformed to the frame of the robot at the requested time.
// Receivers expect a scan to be one turn of a beam: the points are sorted by angle, and their range
// is measured from the robot. Points without a hit stay in the scan, since they show free space.
// For a scanner that sends sectors, the newest scan of each sector is kept. When the sum has more
// points than a message can hold, every n-th point is dropped, evenly over all directions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "components/geometry/pose.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

class ScanMerger {
 public:
  static constexpr std::size_t kSourcesMax = 4;
  static constexpr std::size_t kPointsMax = decltype(Scan2dData::points)::kMax;

  ScanMerger();

  // `odometry`: its pose at the time of the scan. False: the pose is invalid, or the scan is older
  // than the stored one.
  bool take(std::size_t source, const Scan2dData& scan, const Pose& odometry);
  void forget(std::size_t source);

  // False: there is no scan. The segment of each point is the number of its source, from 1.
  // Allocates nothing when `merged` has capacity; refPos is not changed.
  bool merge(TimeStamp now, const Pose& odometry, Scan2dData& merged);
  // Number of points that did not fit into the last merged scan.
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  struct Point {
    double x;  // mm, in the frame of the odometry
    double y;
    std::int32_t sector;
    std::int32_t type;
    std::int16_t intensity;
  };
  struct Source {
    std::vector<Point> points;
    TimeStamp newest = 0;
    TimeStamp oldest = 0;  // start of its newest scan
    std::int32_t range_max = 0;
    bool known = false;
  };
  struct Seen {
    double angle;
    ScanPoint point;
  };
  void collect(const Source& source, std::int16_t segment, const Pose& odometry);

  std::array<Source, kSourcesMax> sources_;
  std::vector<Seen> seen_;
  std::size_t left_out_ = 0;
};

}  // namespace rack::perception
