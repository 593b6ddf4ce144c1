// The common part of LadarSim and Scan2dSim: scans of a floor plan from the pose that the odometry
// reports.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "components/world/core/models.h"
#include "os/file.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/odometry.h"

namespace rack::sim {

inline constexpr std::size_t kMapScannerParameters = 7;
inline constexpr std::array<ParameterInfo, kMapScannerParameters> kMapScanner = {{
    {.name = "odometry",
     .initial = 0,
     .help = "the odometry",
     .min = 0,
     .max = 255,
     .system_help = "the odometry"},
    {"maxRange", 10000, "maximum range, mm", 1, 1e6},
    {"angleRes", 1, "angle between two rays, deg", 1, 360},
    host_file({"mapFile", "", "floor plan, a DXF text file", 0, 0, true}),
    {"mapScaleFactor", 1000, "mm per unit of the plan; 0: as it states", 0, 1e6},
    {"mapOffsetX", 0, "north of the plan that is x = 0, in its units"},
    {"mapOffsetY", 0, "east of the plan that is y = 0, in its units"},
}};

inline constexpr std::size_t kFileMax = 64 << 20;  // larger than any drawing of a floor

// Parts that cannot be read are logged; a file that is not a drawing is an error.
inline Result<FloorMap> load_map(const std::string& path, double scale, double offset_x,
                                 double offset_y, TextLog& log) {
  const auto text = tims::os::read_file(path, kFileMax);
  if (!text) return tims::Error(text.error().code(), "map " + text.error().detail());
  const auto plan = read_plan("map " + path, *text, scale);
  if (!plan) return plan.error();
  for (const std::string& remark : plan->drawing.remarks) log.warning("{}", remark);
  FloorMap map(plan->drawing, plan->scale, offset_x, offset_y);
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
    auto map = load_map(this->text("mapFile"), this->integer("mapScaleFactor"),
                        this->integer("mapOffsetX"), this->integer("mapOffsetY"), this->log());
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
