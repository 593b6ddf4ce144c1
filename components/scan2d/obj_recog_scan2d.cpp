// ObjRecogScan2d: people and other objects in a scan that are not in the map.
#include <array>
#include <memory>
#include <mutex>

#include "components/perception/object_recogniser.h"
#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "rack/data_module.h"
#include "rack/data_of_time.h"
#include "rack/input.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"

namespace rack::scan2d {
namespace {

using localisation::LikelihoodField;
using perception::ObjectRecogniser;

constexpr std::array<ParameterInfo, 15> kParameters = {{
    required_partner("scan2d", "the scan"),
    optional_partner("position", "the position", "the position; -1: refPos of the scan"),
    host_file({"mapFile", "", "map of static obstacles: floor plan (DXF) or map of ROS (.yaml)"}),
    navigation::kMapScaleFactor,
    navigation::kMapOffsetX,
    navigation::kMapOffsetY,
    navigation::kMapLayers,
    navigation::kMapResolution,
    optional_partner("gridMap", "the GridMap", "the GridMap with the map; -1: none"),
    optional_partner("featureMap", "the FeatureMap", "the FeatureMap with the map; -1: none"),
    {"mapTolerance", 250, "points within this distance of the map's obstacles are ignored [mm]", 0,
     10000},
    {"ladarOffsetX", 0, "position of the ladar on the robot, forward [mm]"},
    {"ladarOffsetY", 0, "the same to the right [mm]"},
    {"maxRange", 30000, "maximum range [mm]", 1, 1e9},
    {"maxObjects", 100, "maximum number of objects sent; programs of the original accept up to 100",
     1, 300},
}};

constexpr ModuleInfo kInfo{
    .program = "ObjRecogScan2d",
    .purpose = "Detects people and other objects in a scan that are not in the map.",
    .class_id = tims::class_id::kObjRecog,
    .parameters = kParameters,
};

constexpr int kMissesMax = 20;  // scans in a row without a position of their time
constexpr std::chrono::milliseconds kPositionLate{300};  // it is waited for

class ObjRecogScan2d : public DataModule<ObjRecogData> {
 public:
  ObjRecogScan2d() : DataModule(kInfo, {.history = 20}) { reserve_all(scan_); }

 private:
  Result<void> module_on() override {
    if (auto map = take_map(); !map) return map;
    if (auto on = position_.turn_on(); !on) return on;
    misses_ = 0;
    {
      const std::lock_guard lock(recogniser_mutex_);
      recogniser_.reset();
      recogniser_ = std::make_unique<ObjectRecogniser>(settings(), field_.get());
    }
    const auto granted = scan2d_.start();
    if (!granted) return granted.error();
    set_period(*granted);
    return DataModule::module_on();
  }

  [[nodiscard]] perception::RecogniserSettings settings() const {
    return {.scanner = {.x = static_cast<double>(integer("ladarOffsetX")),
                        .y = static_cast<double>(integer("ladarOffsetY"))},
            .range_max = static_cast<double>(integer("maxRange")),
            .tolerance = static_cast<double>(integer("mapTolerance")),
            .objects_max = static_cast<std::size_t>(integer("maxObjects"))};
  }

  void module_off() override { scan2d_.stop(); }

  // --- the map, if one is configured

  Result<void> take_map() {
    std::unique_ptr<LikelihoodField> field;
    const std::string path = text("mapFile");
    grid_map_.connect();
    feature_map_.connect();
    if (!path.empty() || grid_map_ || feature_map_) {
      const auto map = read_map(path);
      if (!map) return map.error();
      auto made = LikelihoodField::of(*map, {});
      if (!made) return made.error();
      field = std::make_unique<LikelihoodField>(std::move(made).value());
      log().info("map: {} x {} cells of {} mm", map->rows, map->columns, map->resolution);
    }
    const std::lock_guard lock(recogniser_mutex_);
    recogniser_.reset();  // it refers to the old map
    field_ = std::move(field);
    return {};
  }

  [[nodiscard]] PlanPlacement placement() const {
    return {.scale = static_cast<double>(integer("mapScaleFactor")),
            .offset_x = static_cast<double>(integer("mapOffsetX")),
            .offset_y = static_cast<double>(integer("mapOffsetY")),
            .layers = text("mapLayers")};
  }

  Result<localisation::GridMap> read_map(const std::string& path) {
    const auto resolution = static_cast<double>(integer("mapResolution"));
    if (!path.empty()) {
      auto loaded = navigation::load_map(path, placement(), resolution);
      if (!loaded) return loaded.error();
      for (const std::string& remark : loaded->remarks) log().warning("{}", remark);
      return std::move(loaded->map);
    }
    if (grid_map_) {
      const auto cells = asked(*grid_map_);
      if (!cells) return cells.error();
      return localisation::read_map(*cells);
    }
    const auto lines = asked(*feature_map_);
    if (!lines) return lines.error();
    return localisation::read_map(*lines, resolution);
  }

  template <typename ProxyType>
  static Result<typename ProxyType::Data> asked(ProxyType& map) {
    if (auto on = map.on(); !on) return on.error();
    return map.get_data();
  }

  // --- for each scan

  Result<void> module_loop() override {
    if (auto come = scan2d_.next(scan_, patience_with(period())); !come) return come;
    PositionData at{.recordingTime = scan_.recordingTime, .pos = scan_.refPos};
    if (position_) {
      if (auto come = position_then_.get(*position_, at, scan_.recordingTime, kPositionLate);
          !come) {
        // The position may be late or may have just started.
        if (++misses_ > kMissesMax) return come;
        return {};
      }
    }
    misses_ = 0;
    {
      const std::lock_guard lock(recogniser_mutex_);
      if (!recogniser_->take(scan_, at)) return {};
      recogniser_->to_message(get_local_buffer());
    }
    return put_local_buffer();
  }

  // --- commands. SET_ESTIMATE is answered by ERROR: only detected objects are reported.

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type == ObjRecogType::kStopRecog) return answered(message, stop(message));
    return DataModule::module_command(message);
  }

  // An empty list stops all objects. An object that still moves is detected again, with a new
  // number.
  Result<void> stop(const tims::MessageView& message) {
    const auto which = decode<ObjRecogData>(message);
    if (!which) return which.error();
    const std::lock_guard lock(recogniser_mutex_);
    if (!recogniser_) return refused("there are no objects yet; turn the component on first");
    if (which->objects.empty()) recogniser_->forget();
    for (const ObjRecogObject& object : which->objects)
      if (!recogniser_->stop(object.objectId))
        return refused("there is no object " + std::to_string(object.objectId));
    return {};
  }

  OwnMailbox work_{*this, 1, body_max<GridMapData>()};
  Input<Scan2dProxy> scan2d_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  DataOfTime<PositionProxy> position_then_;
  Partner<GridMapProxy> grid_map_{*this, "gridMap", work_};
  Partner<FeatureMapProxy> feature_map_{*this, "featureMap", work_};
  Scan2dData scan_;
  int misses_ = 0;
  PriorityMutex recogniser_mutex_;  // protects the members below, for commands
  std::unique_ptr<LikelihoodField> field_;
  std::unique_ptr<ObjectRecogniser> recogniser_;
};

}  // namespace
}  // namespace rack::scan2d

int main(int argc, char** argv) {
  rack::scan2d::ObjRecogScan2d recognition;
  return recognition.run(argc, argv);
}
