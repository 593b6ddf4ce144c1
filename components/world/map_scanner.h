// The common part of LadarSim and Scan2dSim: scans of a floor plan from the pose that the odometry
// reports.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "components/world/core/models.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/odometry.h"

namespace rack::sim {

inline constexpr std::size_t kMapScannerParameters = 8;
inline constexpr std::array<ParameterInfo, kMapScannerParameters> kMapScanner = {{
    partner("odometry", "the odometry"),
    {"maxRange", 10000, "maximum range [mm]", 1, 1e6},
    {"angleRes", 1, "angle between two rays [deg]", 1, 360},
    host_file({"mapFile", "", "floor plan (DXF) or map of ROS (.yaml)", 0, 0, true}),
    navigation::kMapScaleFactor,
    navigation::kMapOffsetX,
    navigation::kMapOffsetY,
    navigation::kMapLayers,
}};

// Parts that cannot be read are logged; a file that is not a map is an error.
inline Result<FloorMap> load_walls(const std::string& path, const PlanPlacement& placement,
                                   TextLog& log) {
  const auto plan = navigation::load_lines(path, placement);
  if (!plan) return tims::Error(plan.error().code(), "map " + plan.error().detail());
  for (const std::string& remark : plan->drawing.remarks) log.warning("map {}", remark);
  FloorMap map(*plan);
  log.info("{} has {} features", path, map.size());
  return map;
}

template <Struct Scan>
class MapScanner : public DataModule<Scan> {
 public:
  explicit MapScanner(const ModuleInfo& info) : DataModule<Scan>(info, {.history = 10}) {}

 private:
  virtual Result<ScanSettings> settings() const = 0;

  Result<void> module_on() override {
    const auto wanted = settings();
    if (!wanted) return wanted.error();
    auto map = load_walls(this->text("mapFile"),
                          {.scale = static_cast<double>(this->integer("mapScaleFactor")),
                           .offset_x = static_cast<double>(this->integer("mapOffsetX")),
                           .offset_y = static_cast<double>(this->integer("mapOffsetY")),
                           .layers = this->text("mapLayers")},
                          this->log());
    if (!map) return map.error();
    model_.emplace(std::move(*map), *wanted);
    const auto granted = odometry_.start();
    if (!granted) return granted.error();
    this->set_period(*granted);
    return DataModule<Scan>::module_on();
  }

  void module_off() override { odometry_.stop(); }

  Result<void> module_loop() override {
    OdometryData position;
    if (auto come = odometry_.next(position, 2 * this->period()); !come) return come;
    model_->measure(position, this->period(), this->get_local_buffer());
    return this->put_local_buffer();
  }

  OwnMailbox work_{*this, 1, 128};
  Input<OdometryProxy> odometry_{*this, "odometry", work_, 1, wire_size<OdometryData>()};
  std::optional<ScanModel> model_;
};

}  // namespace rack::sim
