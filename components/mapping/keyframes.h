// Keyframes: the scans of a drive that the map is made of, and the motion from each to the next.
// Pure.
//
// A keyframe is taken every 0.2 m or 9 degrees. It is matched with the scans of the last metres
// together, starting at the pose of the odometry; directions that the scans do not determine (along
// a bare corridor) follow the odometry. When the match is poor the odometry has jumped (wheels
// slip), and the surroundings are searched.
//
// People who walk along with the robot look the same in each scan, as if it stood still. In a
// corridor with a door now and then, they are most of what determines the distance. Therefore a
// direction needs more points than they have. When the moving points have been forgotten
// (moving.h), the keyframes are matched again, and fewer points are enough.
#pragma once

#include <functional>
#include <optional>

#include "components/mapping/drive.h"
#include "components/mapping/pose_graph.h"
#include "components/mapping/view.h"

namespace rack::mapping {

enum class Placed : std::uint8_t { kByScans, kBySearch, kByOdometry };

struct Keyframe {
  std::size_t scan = 0;  // index in the drive
  Pose odometry{};
  double travelled = 0;  // mm, distance driven until here
  std::vector<ScanPoint2d> points{};
  View view{};
  Placed placed = Placed::kByScans;
};

struct Track {
  std::vector<Keyframe> keyframes{};
  std::vector<Pose> poses{};  // of the keyframes
  std::vector<Edge> edges{};  // from each to the next, by scans and by odometry
  std::size_t searched = 0;   // keyframes found by a search
  std::size_t unmatched = 0;  // keyframes placed by odometry only
};

// Progress report: the step, and its amount done; returns false to stop.
using Progress = std::function<bool(std::string_view what, std::size_t done, std::size_t all)>;

// Information of a step of the odometry, in the frame of its start.
Information odometry_information(const Pose& step);

// The points of keyframes in the frame of `frame`.
std::vector<ScanPoint2d> points_around(const Track& track, std::size_t first, std::size_t last,
                                       const Pose& frame);

// Nothing: stopped by `progress`.
std::optional<Track> follow(const Drive& drive, const Progress& progress);
// The same keyframes again, with the points that are left.
std::optional<Track> follow_again(Track track, const Progress& progress);

}  // namespace rack::mapping
