// The decisions of PathRDDF: the path that it sends. Pure.
//
// A path has one of three origins: waypoints (a file, or SET_RDDF), a destination, for which it is
// planned through free space, or a detour around an obstacle, which returns to the path behind it.
// Free space is the map, or a free area around the robot, without the obstacles that the scanner
// has seen since the destination was set, that no wall of the map explains, and that have not gone.
// Plans take several periods. If there is no path around the obstacles, a new destination is
// planned without them: people may have gone when the robot is there. A path that already leads to
// the destination stays until a better one is found. A destination is kept when the component
// starts again.
//
// When a path is blocked, the vehicle may make room for who comes towards it (making_room.h). The
// path to the place aside continues with splines that must not be driven (is_waiting()) to the
// destination, so that the pilot has not arrived.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "components/path/detour.h"
#include "components/path/goal_planner.h"
#include "components/path/making_room.h"
#include "components/path/seen_obstacles.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/path.h"
#include "rack/proxies/scan2d.h"

namespace rack::path {

struct RouteSettings {
  ChassisParamData chassis{};
  PathLimits limits{};        // with which it starts; MAKE changes them
  double comfort = 300;       // mm, as in PlanSettings
  double plan_width = 40000;  // mm, of the free area around the robot if there is no map
  i32 layer = 0;              // of the waypoints to drive
};

struct PlanningMap {
  FreeSpace space{};
  // False: there is no map; `space` is empty and has the size of the free area.
  bool is_known = true;
};

class RoutePlanner {
 public:
  RoutePlanner();  // allocates the memory of paths and obstacles

  // Forgets everything but waypoints and destination. kInvalidArgument: limits with which nothing
  // can drive.
  Result<void> begin(const RouteSettings& settings, PlanningMap map);
  // The path of the waypoints, unless there is a destination. kInvalidArgument: it cannot be
  // driven.
  Result<void> begin_route();
  void end() { planning_ = false; }

  void take_position(const Pose& robot);
  void take_scan(const Scan2dData& scan);
  // One period; `now`: its time. Writes the path with the time when it was made. Returns why a plan
  // failed.
  std::optional<std::string> step(TimeStamp now, PathData& data);

  // --- commands; kInvalidArgument: not possible now

  void set_waypoints(std::span<const Waypoint2d> waypoints);
  // Of the layer; a value that is not positive keeps that of the start.
  Result<void> make(const PathMakeData& command, tims::Address sender);
  Result<void> set_destination(const PathDestData& destination, tims::Address sender);
  Result<void> replan(const PathReplanData& from);
  void set_layer(i32 layer) { settings_.layer = layer; }
  [[nodiscard]] i32 layer() const { return settings_.layer; }
  // Makes room for somebody, until there is a path to the destination again.
  [[nodiscard]] bool makes_room() const { return room_.is_active(); }
  // Without a map: nothing.
  [[nodiscard]] const FreeSpace* map() const { return map_.is_known ? &map_.space : nullptr; }

 private:
  Result<void> make_route();
  const double* begin_at_the_robot();
  Result<void> plan_destination();
  Result<void> begin_plan(bool avoids_obstacles);
  Result<void> plan_detour(const OnPath& at, double to_obstacle);
  std::optional<std::string> go_on_planning();
  bool waits_instead();
  bool make_room();
  bool plan_aside();
  void take_path_aside();
  void go_on_aside(TimeStamp now);
  Result<void> blocked_aside();
  void take(std::span<const PolarSpline> path);
  void survey();
  void release_hull();

  RouteSettings settings_;
  PathLimits limits_;
  std::vector<Waypoint2d> waypoints_;
  std::vector<Waypoint2d> route_;  // waypoints of the selected layer
  std::optional<PathDestData> destination_;
  std::optional<tims::Address> sent_by_;  // sender of the destination; its next MAKE is ignored
  std::optional<Place> clicked_;          // the first click
  Pose began_;
  Pose robot_;
  bool located_ = false;
  SeenObstacles seen_;
  PlanningMap map_;
  FreeSpace space_;
  std::optional<GoalPlanner> planner_;
  bool planning_ = false;
  bool must_replan_ = false;      // as soon as the position is known
  bool avoids_obstacles_ = true;  // the plan in progress, those that were seen
  bool leads_there_ = false;      // the path, to the destination
  bool detour_ = false;
  OnPath back_;
  MakingRoom room_;
  std::vector<PolarSpline> path_;
  std::vector<PolarSpline> before_;
  TimeStamp made_ = 0;
  bool is_new_ = true;
};

}  // namespace rack::path
