// PathRDDF: a path along a route, or to a destination.
#include <array>
#include <mutex>
#include <optional>
#include <utility>

#include "components/path/rddf.h"
#include "components/path/route_planner.h"
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
constexpr int kSilence = 20;  // periods without a position
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
    {"cellSize", 100, "cell size of the planning map [mm]", 10, 1000},
    {"planWidth", 40000, "without a map: width of the free area around the robot [mm]", 1000,
     200000},
    {"vMax", 0, "maximum speed [mm/s]; 0: that of the chassis", 0, kMax},
    {"accMax", 0, "acceleration [mm/s2]; 0: 70 % of the limit of the chassis", 0, kMax},
    {"decMax", 0, "deceleration [mm/s2]; 0: 70 % of the limit of the chassis", 0, kMax},
    {"omegaMax", 0, "maximum angular speed [deg/s]; 0: 90 % of the limit of the chassis", 0, 3600},
    {"accLateral", 1000, "lateral acceleration in bends [mm/s2]", 1, kMax},
    {"lbo", 500,
     "corridor to each side for waypoints without one [mm]; at least the width of the chassis", 1,
     kMax},
    {"comfort", 300, "additional clearance that a plan prefers [mm]", 0, kMax},
    {"layer", 0, "layer of the waypoints to drive"},
    {"periodTime", 50, "period of the data [ms]", 1, 60000},
}};

constexpr ModuleInfo kInfo{
    .program = "PathRDDF",
    .purpose = "Plans a path along a route, or to a destination.",
    .class_id = tims::class_id::kPath,
    .parameters = kParameters,
    .command_slots = 8,
    .command_body_max = body_max<PathRddfData>(),
};

class PathRddf : public DataModule<PathData> {
 public:
  PathRddf() : DataModule(kInfo, {.history = 2}) { reserve_all(scan_); }

 private:
  // --- on

  Result<void> module_on() override {
    if (auto good = get_ready(); !good) return good;
    return DataModule::module_on();
  }

  // Nothing is locked while others are asked and files are read: commands are answered meanwhile.
  Result<void> get_ready() {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    chassis_proxy_.connect();
    const auto chassis = chassis_proxy_->get_parameter();
    if (!chassis) return chassis.error();
    bool has_map = true;
    auto map = load_map(has_map);
    if (!map) return map.error();
    {
      const std::lock_guard lock(state_mutex_);
      if (auto good = planner_.begin(settings(*chassis), std::move(*map), has_map); !good)
        return good;
    }
    if (const auto granted = position_input_.start(); !granted) return granted.error();
    if (const auto granted = scan_input_.start(); !granted) return granted.error();
    auto route = load_route();
    if (!route) return route.error();
    const std::lock_guard lock(state_mutex_);
    if (!route->empty()) {
      for (Waypoint2d& waypoint : *route) waypoint.layer = planner_.layer();
      planner_.set_waypoints(*route);
    }
    return planner_.begin_route();
  }

  void module_off() override {
    position_input_.stop();
    scan_input_.stop();
    const std::lock_guard lock(state_mutex_);
    planner_.end();
  }

  [[nodiscard]] RouteSettings settings(const ChassisParamData& chassis) const {
    return {.chassis = chassis,
            .limits = limits_of_parameters(chassis),
            .comfort = 1.0 * integer("comfort"),
            .plan_width = 1.0 * integer("planWidth"),
            .layer = integer("layer")};
  }

  [[nodiscard]] PathLimits limits_of_parameters(const ChassisParamData& chassis) const {
    PathLimits limits = limits_of(chassis);
    if (integer("vMax") > 0) limits.speed_max = std::min(limits.speed_max, 1.0 * integer("vMax"));
    limits.backward_max = std::min(limits.backward_max, limits.speed_max);
    if (integer("accMax") > 0) limits.acceleration = integer("accMax");
    if (integer("decMax") > 0) limits.deceleration = integer("decMax");
    if (integer("omegaMax") > 0) limits.omega_max = radians(integer("omegaMax"));
    limits.lateral_acceleration = integer("accLateral");
    limits.corridor = std::max(1.0 * integer("lbo"), limits.half_width + 100);
    return limits;
  }

  tims::Result<FreeSpace> load_map(bool& has_map) {
    const double cell = integer("cellSize");
    const std::string file = text("mapFile");
    if (!file.empty()) {
      const auto plan =
          navigation::load_plan(file, {.scale = static_cast<double>(integer("mapScaleFactor")),
                                       .offset_x = static_cast<double>(integer("mapOffsetX")),
                                       .offset_y = static_cast<double>(integer("mapOffsetY")),
                                       .layers = text("mapLayers")});
      if (!plan) return plan.error();
      for (const std::string& remark : plan->remarks) log().warning("{}", remark);
      return FreeSpace::of(*plan, cell, 2000);
    }
    if (auto on = grid_map_.turn_on(); !on) return on.error();
    if (grid_map_) {
      const auto data = grid_map_->get_data();
      if (!data) return data.error();
      return FreeSpace::of(*data);
    }
    has_map = false;
    const double width = integer("planWidth");
    return FreeSpace::empty({}, width, width, cell);
  }

  // Empty: there is no file.
  tims::Result<std::vector<Waypoint2d>> load_route() {
    const std::string file = text("rddfFile");
    if (file.empty()) return std::vector<Waypoint2d>{};
    const auto read = tims::os::read_file(file, kFileMax);
    if (!read) return read.error();
    const auto points = read_rddf(*read);
    if (!points) return tims::Error(points.error().code(), file + ": " + points.error().detail());
    auto waypoints = to_waypoints(
        *points, [&](const PositionWgs84Data& at) { return position_input_->wgs84_to_pos(at); });
    if (!waypoints)
      return tims::Error(waypoints.error().code(), file + ": " + waypoints.error().detail());
    log().info("{} has {} waypoints", file, waypoints->size());
    return std::vector<Waypoint2d>(waypoints->begin(), waypoints->end());
  }

  // --- one period

  Result<void> module_loop() override {
    sleep_until_next(period());
    if (auto come = look(); !come) return come;
    const std::lock_guard lock(state_mutex_);
    if (const auto failure = planner_.step(time_stamp(), get_local_buffer()))
      log().warning("No plan: {}", *failure);
    return put_local_buffer();
  }

  Result<void> look() {
    PositionData position;
    const auto come = position_input_.newest(position, kSilence);
    if (!come) return come.error();
    const auto seen = scan_input_ ? scan_input_.newest(scan_) : Result<bool>(false);
    if (!seen) return seen.error();
    const std::lock_guard lock(state_mutex_);
    if (*come) planner_.take_position(Pose::of(position.pos));
    if (*seen) planner_.take_scan(scan_);
    return {};
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
      case PathType::kGetDbgGridmap:
        return send_map(message);
      case PathType::kGetLayer: {
        const std::lock_guard lock(state_mutex_);
        reply(message.header, PathType::kLayer, PathLayerData{planner_.layer()});
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  Result<void> send_map(const tims::MessageView& message) {
    if (!is_on()) return refused("the path component is off; turn it on first");
    GridMapData map;
    {
      const std::lock_guard lock(state_mutex_);
      if (planner_.map() == nullptr) return refused("it plans without a map: set mapFile");
      map = planner_.map()->message();
    }
    reply(message.header, PathType::kDbgGridmap, map);
    return {};
  }

  Result<void> set_rddf(const tims::MessageView& message) {
    if (auto good = decode(message, rddf_); !good) return good;
    const std::lock_guard lock(state_mutex_);
    planner_.set_waypoints(rddf_.waypoints);
    return {};
  }

  Result<void> make(const tims::MessageView& message) {
    const auto command = decode<PathMakeData>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    return planner_.make(*command, message.header.src);
  }

  Result<void> set_destination(const tims::MessageView& message) {
    const auto command = decode<PathDestData>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    return planner_.set_destination(*command, message.header.src);
  }

  Result<void> replan(const tims::MessageView& message) {
    const auto from = decode<PathReplanData>(message);
    if (!from) return from.error();
    if (!is_on()) return refused("the path component is off; turn it on first");
    const std::lock_guard lock(state_mutex_);
    return planner_.replan(*from);
  }

  Result<void> set_layer(const tims::MessageView& message) {
    const auto command = decode<PathLayerData>(message);
    if (!command) return command.error();
    const std::lock_guard lock(state_mutex_);
    planner_.set_layer(command->layer);
    return {};
  }

  OwnMailbox work_{*this, 4, body_max<GridMapData>()};
  Partner<ChassisProxy> chassis_proxy_{*this, "chassis", work_};
  Partner<GridMapProxy> grid_map_{*this, "gridMap", work_};
  Input<PositionProxy> position_input_{*this, "position", work_, 10, wire_size<PositionData>()};
  Input<Scan2dProxy> scan_input_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  Scan2dData scan_;
  PathRddfData rddf_;  // used by the command task

  PriorityMutex state_mutex_;  // protects the planner
  RoutePlanner planner_;
};

}  // namespace
}  // namespace rack::path

int main(int argc, char** argv) {
  rack::path::PathRddf path;
  return path.run(argc, argv);
}
