// The scans of a drive that its map is made of, and how the robot got from one to the next: each
// scan is laid on those before it. Pure.
//
// A scan is taken each 0.2 m or 9 degrees. It is matched with all scans of the last metres
// together, starting where the odometry says; what the scans do not tell (the way along a bare
// corridor), the odometry does. When the match is poor the odometry has jumped (wheels slip), and
// the scan is searched for around.
#pragma once

#include <functional>
#include <optional>

#include "components/mapping/drive.h"
#include "components/mapping/pose_graph.h"

namespace rack::mapping {

struct Keyframe {
  std::size_t scan = 0;  // of the drive
  Pose odometry{};
  double way = 0;  // mm driven until here
  std::vector<ScanPoint2d> points{};
};

struct Track {
  std::vector<Keyframe> keyframes{};
  std::vector<Pose> poses{};  // of the keyframes
  std::vector<Edge> edges{};  // from each to the next, by scans and by odometry
  std::size_t searched = 0;   // keyframes that the odometry did not lead to
  std::size_t unmatched = 0;  // that only the odometry knows of
};

// What is being done, and how much of it; false: it shall end.
using Progress = std::function<bool(std::string_view what, std::size_t done, std::size_t all)>;

// Where a step of the odometry leads, and how sure it is, in the frame of its beginning.
Information odometry_information(const Pose& step);

// The points of some keyframes, seen from `frame`.
std::vector<ScanPoint2d> points_around(const Track& track, std::size_t first, std::size_t last,
                                       const Pose& frame);

// Nothing: `progress` said so.
std::optional<Track> follow(const Drive& drive, const Progress& progress);

}  // namespace rack::mapping
