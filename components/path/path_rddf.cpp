// PathRDDF: a path along a route, or to a destination.
#include <array>
#include <mutex>
#include <optional>
#include <utility>

#include "components/path/detour.h"
#include "components/path/rddf.h"
#include "components/path/vehicle.h"
#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "os/file.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"

namespace rack::path {
namespace {

constexpr double kMax = 1e6;
constexpr int kSilence = 20;           // periods without a position
constexpr int kPosesAPeriod = 1500;    // poses that a search expands per period
constexpr double kDirectionOnly = 10;  // mm/s, as in waypoints
constexpr double kExplained = 150;  // mm: a point this near to a wall of the map is explained by it
constexpr std::size_t kMarksMax = 20000;  // marks of obstacles seen by the scanner
constexpr std::array<double, 5> kBehind = {2000, 4000, 7000, 12000,
                                           20000};  // distances behind an obstacle, mm
constexpr i32 kLandmark = 1;
constexpr std::size_t kFileMax = 64 << 20;

constexpr std::array<ParameterInfo, 21> kParameters = {{
    host_file(
        {"rddfFile", "",
         "route file (RDDF of the DARPA Grand Challenge); empty: the route comes by SET_RDDF"}),
    partner("chassis", "the chassis", "the chassis, for its size and limits"),
    partner("position", "the position"),
    optional_partner("scan2d", "the scan", "the scan; -1: none, plans use the map only"),
    optional_partner("gridMap", "the grid map", "a grid map for planning; -1: none"),
    host_file({"mapFile", "", "map for planning: floor plan (DXF) or map of ROS (.yaml)"}),
    navigation::kMapScaleFactor,
    navigation::kMapOffsetX,
    navigation::kMapOffsetY,
    navigation::kMapLayers,
    {"cellSize", 100, "cell size of the planning map, mm", 10, 1000},
    {"planWidth", 40000, "without a map: width of the free area around the robot, mm", 1000,
     200000},
    {"vMax", 0, "maximum speed, mm/s; 0: that of the chassis", 0, kMax},
    {"accMax", 0, "acceleration, mm/s2; 0: 70 % of the limit of the chassis", 0, kMax},
    {"decMax", 0, "deceleration, mm/s2; 0: 70 % of the limit of the chassis", 0, kMax},
    {"omegaMax", 0, "maximum angular speed, deg/s; 0: 90 % of the limit of the chassis", 0, 3600},
    {"accLateral", 1000, "lateral acceleration in bends, mm/s2", 1, kMax},
    {"lbo", 500,
     "corridor to each side for waypoints without one, mm; at least the width of the chassis", 1,
     kMax},
    {"comfort", 300, "additional clearance that a plan prefers, mm", 0, kMax},
    {"layer", 0, "layer of the waypoints to drive"},
    {"periodTime", 50, "period of the data, ms", 1, 60000},
}};

constexpr ModuleInfo kInfo{
    .program = "PathRDDF",
    .purpose = "Plans a path along a route, or to a destination.",
    .class_id = tims::class_id::kPath,
    .parameters = kParameters,
    .command_slots = 8,
    .command_body_max = body_max<PathRddfData>(),
};

Pose pose_of(const Position2d& pos) {
  return {.x = static_cast<double>(pos.x),
          .y = static_cast<double>(pos.y),
          .rho = static_cast<double>(pos.rho)};
}

// Java programs write the bits of a float (1 or -1) into this integer field.
double direction_or_speed(i32 field) {
  constexpr i32 kMinusOne = static_cast<i32>(0xBF800000);
  constexpr i32 kOne = 0x3F800000;
  if (field == kMinusOne) return -1;
  if (field == kOne) return 1;
  return field;
}

class PathRddf : public DataModule<PathData> {
 public:
  PathRddf() : DataModule(kInfo, {.history = 2}) {
    reserve_all(scan_);
    path_.reserve(kSplinesMax);
    before_.reserve(kSplinesMax);
    marks_.reserve(kMarksMax);
    waypoints_.reserve(kWaypointsMax);
  }

 private:
  // --- on

  Result<void> module_on() override {
    if (auto good = get_ready(); !good) return good;
    return DataModule::module_on();
  }

  Result<void> get_ready() {
    const std::lock_guard lock(state_mutex_);
    set_period(std::chrono::milliseconds(integer("periodTime")));
    layer_ = integer("layer");
    located_ = seen_ = planning_ = false;
    chassis_proxy_.connect();
    const auto parameters = chassis_proxy_->get_parameter();
    if (!parameters) return parameters.error();
    chassis_ = *parameters;
    limits_ = own_limits();
    planner_.emplace(PlanSettings{limits_, hull_of(chassis_), 1.0 * integer("comfort")});
    if (auto good = check(limits_); !good) return good;
    if (const auto granted = position_input_.start(); !granted) return granted.error();
    if (const auto granted = scan_input_.start(); !granted) return granted.error();
    if (auto good = load_map(); !good) return good;
    return load_route();
  }

  void module_off() override {
    position_input_.stop();
    scan_input_.stop();
    const std::lock_guard lock(state_mutex_);
    planning_ = false;
  }

  [[nodiscard]] PathLimits own_limits() const {
    PathLimits limits = path::limits_of(chassis_);
    if (integer("vMax") > 0) limits.speed_max = std::min(limits.speed_max, 1.0 * integer("vMax"));
    limits.backward_max = std::min(limits.backward_max, limits.speed_max);
    if (integer("accMax") > 0) limits.acceleration = integer("accMax");
    if (integer("decMax") > 0) limits.deceleration = integer("decMax");
    if (integer("omegaMax") > 0) limits.omega_max = radians(integer("omegaMax"));
    limits.lateral_acceleration = integer("accLateral");
    limits.corridor = std::max(1.0 * integer("lbo"), limits.half_width + 100);
    return limits;
  }

  Result<void> load_map() {
    const double cell = integer("cellSize");
    const std::string file = text("mapFile");
    has_map_ = true;
    if (!file.empty()) {
      const auto plan =
          navigation::load_plan(file, {.scale = static_cast<double>(integer("mapScaleFactor")),
                                       .offset_x = static_cast<double>(integer("mapOffsetX")),
                                       .offset_y = static_cast<double>(integer("mapOffsetY")),
                                       .layers = text("mapLayers")});
      if (!plan) return plan.error();
      for (const std::string& remark : plan->remarks) log().warning("{}", remark);
      return take_map(FreeSpace::of(*plan, cell, 2000));
    }
    if (auto on = grid_map_.turn_on(); !on) return on;
    if (grid_map_) {
      const auto data = grid_map_->get_data();
      if (!data) return data.error();
      return take_map(FreeSpace::of(*data));
    }
    has_map_ = false;
    const double width = integer("planWidth");
    return take_map(FreeSpace::empty({}, width, width, cell));
  }
  Result<void> take_map(tims::Result<FreeSpace> map) {
    if (!map) return map.error();
    map_ = std::move(*map);
    space_ = map_;
    return {};
  }

  Result<void> load_route() {
    const std::string file = text("rddfFile");
    if (!file.empty()) {
      const auto read = tims::os::read_file(file, kFileMax);
      if (!read) return read.error();
      const auto points = read_rddf(*read);
      if (!points) return tims::Error(points.error().code(), file + ": " + points.error().detail());
      const auto waypoints = to_waypoints(
          *points, [&](const PositionWgs84Data& at) { return position_input_->wgs84_to_pos(at); });
      if (!waypoints)
        return tims::Error(waypoints.error().code(), file + ": " + waypoints.error().detail());
      waypoints_.assign(waypoints->begin(), waypoints->end());
      for (Waypoint2d& waypoint : waypoints_) waypoint.layer = layer_;
      log().info("{} has {} waypoints", file, waypoints_.size());
    }
    // The destination is kept while this component is off, or in error.
    must_replan_ = destination_.has_value();
    return must_replan_ ? Result<void>() : make_route();
  }

  // --- one period

  Result<void> module_loop() override {
    sleep_until_next(period());
    if (auto come = look(); !come) return come;
    const std::lock_guard lock(state_mutex_);
    if (must_replan_ && located_) {
      must_replan_ = false;
      if (auto good = plan_destination(); !good)
        log().warning("No plan: {}", good.error().message());
    }
    if (planning_) go_on_planning();
    PathData& data = get_local_buffer();
    if (is_new_) {
      data.splines.assign(path_.begin(), path_.end());
      // Receivers identify a path by its time.
      made_ = made_ == time_stamp() ? made_ + std::chrono::milliseconds(1) : time_stamp();
      data.recordingTime = made_;
      is_new_ = false;
    }
    return put_local_buffer();
  }

  Result<void> look() {
    PositionData position;
    const auto come = position_input_.newest(position, kSilence);
    if (!come) return come.error();
    const std::lock_guard lock(state_mutex_);
    if (*come) {
      robot_ = Pose::of(position.pos);
      located_ = true;
    }
    if (!scan_input_) return {};
    const auto seen = scan_input_.newest(scan_);
    if (!seen) return seen.error();
    if (*seen) {
      seen_from_ = robot_;
      seen_ = true;
    }
    return {};
  }

  void go_on_planning() {
    const auto progress = planner_->advance(kPosesAPeriod);
    if (progress == GoalPlanner::Progress::kSearching) return;
    planning_ = false;
    if (progress == GoalPlanner::Progress::kFailed) {
      log().warning("No plan: {}", planner_->why());
      if (!detour_) take({});  // the old path has another destination
      return;
    }
    if (!detour_) {
      take(planner_->path());
      return;
    }
    before_ = path_;
    path_ = planner_->path();
    append_rest(before_, back_, path_);
    set_speeds(path_);
    is_new_ = true;
  }

  void take(std::span<const PolarSpline> path) {
    path_.assign(path.begin(), path.end());
    is_new_ = true;
  }

  // --- commands

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PathType::kSetRddf:
        return answered(message, set_rddf(message));
      case PathType::kMake:
        return answered(message, make(message));
      case PathType::kSetDestination:
        return answered(message, set_destination(message));
      case PathType::kReplan:
        return answered(message, replan(message));
      case PathType::kSetLayer:
        return answered(message, set_layer(message));
      case PathType::kGetLayer: {
        const std::lock_guard lock(state_mutex_);
        reply(message.header, PathType::kLayer, PathLayerData{layer_});
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  Result<void> set_rddf(const tims::MessageView& message) {
    if (auto good = decode(message, rddf_); !good) return good;
    const std::lock_guard lock(state_mutex_);
    waypoints_.assign(rddf_.waypoints.begin(), rddf_.waypoints.end());
    sent_by_.reset();
    return {};
  }

  Result<void> make(const tims::MessageView& message) {
    const auto command = decode<PathMakeData>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    // Values that are not positive have no effect: the graphical interface sends -1.
    limits_ = own_limits();
    if (command->vMax > 0) limits_.speed_max = std::min<double>(command->vMax, chassis_.vxMax);
    limits_.backward_max = std::min(limits_.backward_max, limits_.speed_max);
    if (command->accMax > 0) limits_.acceleration = command->accMax;
    if (command->decMax > 0) limits_.deceleration = command->decMax;
    if (command->omegaMax > 0) limits_.omega_max = command->omegaMax;
    // The graphical interface sends this message right after SET_DESTINATION, too: then the plan is
    // in progress or done. When the destination was refused, the message must not select another
    // path.
    if (std::exchange(sent_by_, {}) == message.header.src) return {};
    return make_route();
  }

  Result<void> make_route() {
    route_.clear();
    for (const Waypoint2d& waypoint : waypoints_)
      if (waypoint.layer == layer_) route_.push_back(waypoint);
    planning_ = must_replan_ = false;
    destination_.reset();
    const double* start_heading = begin_at_the_robot();
    if (route_.size() < 2) {
      take({});
      return {};
    }
    const auto made = make_path(route_, limits_, start_heading);
    if (!made) return made.error();
    take(*made);
    return {};
  }

  // A list of clicks is a path from the robot's pose at the first of them.
  const double* begin_at_the_robot() {
    const bool clicks = !route_.empty() && std::abs(1.0 * route_[0].speed) == 1;
    if (!clicks || !located_) {
      clicked_.reset();
      return nullptr;
    }
    const Place first{1.0 * route_[0].x, 1.0 * route_[0].y};
    if (route_.size() == 1 || !clicked_ || clicked_->x != first.x || clicked_->y != first.y) {
      clicked_ = first;
      began_ = robot_;
    }
    Waypoint2d start = route_[0];
    start.x = whole_millimetres(began_.x);
    start.y = whole_millimetres(began_.y);
    route_.insert(route_.begin(), start);
    return &began_.rho;
  }

  Result<void> set_destination(const tims::MessageView& message) {
    const auto command = decode<PathDestData>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    sent_by_ = message.header.src;
    if (!located_) return refused("the position is not known yet");
    marks_.clear();
    const auto before = destination_;
    destination_ = *command;
    auto good = plan_destination();
    if (!good) destination_ = before;
    return good;
  }

  Result<void> plan_destination() {
    const double target = direction_or_speed(destination_->speed);
    const double speed = std::abs(target) < kDirectionOnly ? 0 : std::abs(target);
    planner_->set_limits(limits_);
    survey();
    auto good =
        planner_->begin(space_, robot_, pose_of(destination_->pos), target < 0 ? -1 : 1, speed);
    planning_ = good.ok();
    detour_ = false;
    return good;
  }

  Result<void> replan(const tims::MessageView& message) {
    const auto from = decode<PathReplanData>(message);
    if (!from) return from.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    if (!located_) return refused("the position is not known yet");
    if (planning_) return {};  // a plan is in progress
    if (destination_) return plan_destination();
    if (path_.empty()) return refused("there is no path");
    const auto index = static_cast<std::size_t>(std::max(0, from->currSpline));
    if (index >= path_.size())
      return refused("the path has " + std::to_string(path_.size()) + " splines only");
    const OnPath at{index, std::clamp(std::abs(1.0 * from->splinePos.x), 0.0, size(path_[index]))};
    return plan_detour(at, std::max(0.0, 1.0 * from->distToObstacle));
  }

  // Returns to the path at the first place behind the obstacle for which a plan can start.
  Result<void> plan_detour(const OnPath& at, double to_obstacle) {
    survey();
    const double hull = chassis_.boundaryFront + chassis_.boundaryBack;
    const OnPath end = further(path_, at, to_obstacle + hull + kBehind.back());
    keep_to_corridor(space_, std::span(path_).subspan(at.index, end.index - at.index + 1),
                     {robot_.x, robot_.y}, hull);
    planner_->set_limits(limits_);
    Result<void> good = refused("the obstacle extends to the end of the path");
    for (const double behind : kBehind) {
      back_ = further(path_, at, to_obstacle + hull + behind);
      good = planner_->begin(space_, robot_, pose_on(path_, back_));
      if (good) break;
    }
    planning_ = good.ok();
    detour_ = true;
    return good;
  }

  Result<void> set_layer(const tims::MessageView& message) {
    const auto command = decode<PathLayerData>(message);
    if (!command) return command.error();
    const std::lock_guard lock(state_mutex_);
    layer_ = command->layer;
    return {};
  }

  // --- free space: the map, and obstacles seen since the destination was set

  void survey() {
    if (has_map_)
      space_ = map_;
    else
      space_.clear({robot_.x - integer("planWidth") / 2.0, robot_.y - integer("planWidth") / 2.0});
    if (seen_) remember_obstacles();
    for (const Place& mark : marks_) space_.occupy(mark);
    release_hull();
    space_.measure();
  }

  void remember_obstacles() {
    for (const ScanPoint& point : scan_.points) {
      if ((point.type & scan_point::kInvalid) != 0 ||
          (point.type & scan_point::kClassMask) == kLandmark || marks_.size() == kMarksMax)
        continue;
      const Pose at = seen_from_ + Pose{.x = 1.0 * point.x, .y = 1.0 * point.y};
      const Place place{at.x, at.y};
      if (!space_.contains(place) || space_.occupied(place)) continue;
      if (has_map_ && map_.clearance(place) < kExplained) continue;
      space_.occupy(place);
      marks_.push_back(place);
    }
  }

  // The place of the vehicle itself is free.
  void release_hull() {
    const auto step = static_cast<i32>(space_.cell() / 2);
    for (i32 x = -chassis_.boundaryBack.raw(); x <= chassis_.boundaryFront; x += step) {
      for (i32 y = -chassis_.boundaryLeft.raw(); y <= chassis_.boundaryRight; y += step) {
        const Pose at = robot_ + Pose{.x = 1.0 * x, .y = 1.0 * y};
        space_.release({at.x, at.y});
      }
    }
  }

  OwnMailbox work_{*this, 4, body_max<GridMapData>()};
  Partner<ChassisProxy> chassis_proxy_{*this, "chassis", work_};
  Partner<GridMapProxy> grid_map_{*this, "gridMap", work_};
  Input<PositionProxy> position_input_{*this, "position", work_, 10, wire_size<PositionData>()};
  Input<Scan2dProxy> scan_input_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  PathRddfData rddf_;  // used by the command task

  PriorityMutex state_mutex_;  // protects the members below
  ChassisParamData chassis_;
  PathLimits limits_;
  std::vector<Waypoint2d> waypoints_;
  std::vector<Waypoint2d> route_;  // waypoints of the selected layer
  i32 layer_ = 0;
  std::optional<PathDestData> destination_;
  std::optional<tims::Address> sent_by_;  // sender of the destination; its next MAKE is ignored
  std::optional<Place> clicked_;          // the first click
  Pose began_;
  Pose robot_;
  bool located_ = false;
  Scan2dData scan_;
  Pose seen_from_;
  bool seen_ = false;
  FreeSpace map_;
  bool has_map_ = false;
  FreeSpace space_;
  std::vector<Place> marks_;
  std::optional<GoalPlanner> planner_;
  bool planning_ = false;
  bool must_replan_ = false;  // as soon as the position is known
  bool detour_ = false;
  OnPath back_;
  std::vector<PolarSpline> path_;
  std::vector<PolarSpline> before_;
  TimeStamp made_ = 0;
  bool is_new_ = true;
};

}  // namespace
}  // namespace rack::path

int main(int argc, char** argv) {
  rack::path::PathRddf path;
  return path.run(argc, argv);
}
