// Scans of several scanners as one, as if it had been made at one moment (specification, section
// 10.4). Pure.
//
// Scanners do not turn in step, and the robot drives on between their scans. Each scan is therefore
// kept in the frame of the odometry, moved there by the odometry of its own time; the merged scan
// is made of the newest of each scanner, moved back into the frame that the robot has at the moment
// asked for. Receivers know a scan as a turn of one beam: the points are sorted by their angle, and
// their range is that from the robot. What saw nothing stays in it, since that says how far it is
// free. A scanner that comes in sectors keeps its newest of each. When all have more points than a
// message has room for, every so many-th is left out, all around alike.
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

  // `odometry`: its pose at the time of the scan. False: that is no pose, or the scan is older than
  // the one there is.
  bool take(std::size_t source, const Scan2dData& scan, const Pose& odometry);
  void forget(std::size_t source);

  // False: there is no scan. Points get the number of their source, from 1, as their segment.
  // Allocates nothing when `merged` has its room; refPos stays as it is.
  bool merge(TimeStamp now, const Pose& odometry, Scan2dData& merged);
  // How many points the last merged scan had no room for.
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
    TimeStamp oldest = 0;  // when its newest scan began
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
