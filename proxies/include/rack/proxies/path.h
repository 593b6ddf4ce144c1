// A planned path of splines (specification, section 9.17).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct PathType {
  enum : i8 {
    kMake = 21,            // PathMakeData
    kReplan = 22,          // PathReplanData
    kSetDestination = 23,  // PathDestData
    kSetRddf = 24,         // PathRddfData
    kGetDbgGridmap = 25,   // answered by kDbgGridmap; ERROR when off or without a map
    kGetLayer = 26,        // answered by kLayer or kLayerOfC
    kSetLayer = 27,        // PathLayerData
    kDbgGridmap = -21,     // GridMapData: ours, no program of the original sends it
    kLayer = -22,          // PathLayerData, with the number of Java programs, which we use
    // the same with the number of C programs, although replies are normally < 0
    kLayerOfC = 18,
  };
};

struct PathData {
  TimeStamp recordingTime = 0;
  Count splineNum = {};
  Sequence<PolarSpline, 6000> splines = {};
};

struct PathMakeData {
  MillimetresPerSecond<i32> vMax = 0;
  MillimetresPerSecond2<i32> accMax = 0;
  MillimetresPerSecond2<i32> decMax = 0;
  RadiansPerSecond<f32> omegaMax = 0;
};

struct PathReplanData {
  i32 currSpline = 0;         // index of the first spline to plan again
  Position2d splinePos = {};  // of the robot, relative to that spline
  Millimetres<i32> distToObstacle = 0;
  Millimetres<i32> pathLength = 0;  // remaining length
};

struct PathDestData {
  Position2d pos = {};
  MillimetresPerSecond<i32> speed = 0;  // Java programs send a float here
  i32 layer = 0;
};

struct PathRddfData {
  Count waypointNum = {};
  Sequence<Waypoint2d, 6000> waypoints = {};  // our limit; the original specifies none
};

struct PathLayerData {
  i32 layer = 0;
};

// For commands that send a path or its pilot to a destination: planning searches the whole map
// before the answer.
inline constexpr ProxyTimeouts kPlanningTimeouts{.data = std::chrono::seconds(3)};

class PathProxy : public DataProxy<PathData, tims::class_id::kPath> {
 public:
  using DataProxy::DataProxy;

  Result<void> make(const PathMakeData& limits) { return command(PathType::kMake, limits); }
  Result<void> replan(const PathReplanData& from) { return command(PathType::kReplan, from); }
  Result<void> set_destination(const PathDestData& destination) {
    return command(PathType::kSetDestination, destination);
  }
  // Does not wait for the answer: see take_answer().
  Result<void> post_replan(const PathReplanData& from) { return post(PathType::kReplan, from); }
  Result<void> post_destination(const PathDestData& destination) {
    return post(PathType::kSetDestination, destination);
  }
  Result<void> set_rddf(const PathRddfData& waypoints) {
    return command(PathType::kSetRddf, waypoints);
  }
  // The map in which paths are planned, in cells as small as the message has room for.
  Result<GridMapData> get_dbg_gridmap() {
    return query<GridMapData>(PathType::kGetDbgGridmap, PathType::kDbgGridmap);
  }
  Result<i32> get_layer() {
    static constexpr i8 kAnswers[] = {PathType::kLayer, PathType::kLayerOfC};
    const auto answer = read<PathLayerData>(ask(PathType::kGetLayer, kAnswers, data_timeout()));
    if (!answer) return answer.error();
    return answer->layer;
  }
  Result<void> set_layer(i32 layer) { return command(PathType::kSetLayer, PathLayerData{layer}); }
};

}  // namespace rack
