// FeatureMap: a map of lines that users view and edit.
#include <array>
#include <atomic>
#include <mutex>

#include "components/files/file_folder.h"
#include "components/localisation/line_map.h"
#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"
#include "rack/proxies/position.h"
#include "tims/origin.h"

namespace rack::navigation {
namespace {

using localisation::LineMap;

constexpr std::array<ParameterInfo, 7> kParameters = {{
    host_file(
        {"mapFile", "",
         "floor plan (DXF) or map of ROS (.yaml), whose walls become lines; empty: start with an "
         "empty map"}),
    kMapScaleFactor,
    kMapOffsetX,
    kMapOffsetY,
    kMapLayers,
    optional_partner("position", "the position",
                     "the position; of large maps, only lines near it are sent; -1: none"),
    {"period", 1000, "period of the data [ms]", 10, 60000},
}};

constexpr ModuleInfo kInfo{
    .program = "FeatureMap",
    .purpose = "A map of lines that users view and edit.",
    .class_id = tims::class_id::kFeatureMap,
    .parameters = kParameters,
};

class FeatureMap : public DataModule<FeatureMapData> {
 public:
  FeatureMap() : DataModule(kInfo, {.history = 2}) {}

 private:
  // A loaded or edited map is kept when the component is turned off and on.
  Result<void> module_on() override {
    if (const std::string path = text("mapFile"); !begun_ && !path.empty())
      if (auto loaded = load(path); !loaded) return loaded;
    begun_ = true;
    if (auto on = position_.turn_on(); !on) return on;
    set_period(std::chrono::milliseconds(integer("period")));
    return DataModule::module_on();
  }

  Result<void> module_loop() override {
    Pose robot;
    FeatureMapData& data = get_local_buffer();
    sleep_until_next(period());
    data.recordingTime = time_stamp();
    if (position_) {
      const auto position = position_->get_data();
      if (!position) return position.error();
      robot = Pose::of(position->pos);
    }
    {
      const std::lock_guard lock(map_mutex_);
      map_.fill(robot, data);
    }
    return put_local_buffer();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case FeatureMapType::kLoadMap:
        return with<FileName>(message, [&](const FileName& file) {
          const auto path = file_to_read(file.view(), tims::is_foreign(message.header));
          if (!path) return Result<void>(path.error());
          auto loaded = load(*path);
          if (loaded) set_parameter("mapFile", *path);
          return loaded;
        });
      case FeatureMapType::kSaveMap:
        return with<FileName>(message, [&](const FileName& file) { return save(file.view()); });
      case FeatureMapType::kAddLine:
        return edit(message, [&](const auto& line) { return map_.add(line.feature); });
      case FeatureMapType::kDeleteLine:
        return edit(message, [&](const auto& line) { return map_.erase(line.featureNumTemp); });
      case FeatureMapType::kDisplaceLine:
        return edit(message, [&](const auto& line) {
          return map_.displace(line.featureNumTemp, line.feature);
        });
      case FeatureMapType::kSetLayer:
        return with<FeatureMapLayerData>(message, [&](const FeatureMapLayerData& layers) {
          const std::lock_guard lock(map_mutex_);
          map_.show(layers);
          return Result<void>();
        });
      case FeatureMapType::kGetLayer: {
        const std::lock_guard lock(map_mutex_);
        reply(message.header, FeatureMapType::kLayer, map_.layers());
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  // Decodes and executes a command, and answers by OK.
  template <typename Body, typename Do>
  Result<void> with(const tims::MessageView& message, const Do& what) {
    const auto body = decode<Body>(message);
    if (!body) return body.error();
    return answered(message, what(*body));
  }
  template <typename Do>
  Result<void> edit(const tims::MessageView& message, const Do& what) {
    return with<FeatureMapFeature>(message, [&](const FeatureMapFeature& line) {
      const std::lock_guard lock(map_mutex_);
      return what(line);
    });
  }

  [[nodiscard]] PlanPlacement placement() const {
    return {.scale = static_cast<double>(integer("mapScaleFactor")),
            .offset_x = static_cast<double>(integer("mapOffsetX")),
            .offset_y = static_cast<double>(integer("mapOffsetY")),
            .layers = text("mapLayers")};
  }
  // Without a scale: that of the plan that was loaded.
  [[nodiscard]] PlanPlacement placement_for_saving() const {
    PlanPlacement wanted = placement();
    if (wanted.scale == 0) wanted.scale = unit_;
    return wanted;
  }

  Result<void> load(const std::string& path) {
    const auto plan = load_lines(path, placement());
    if (!plan) return plan.error();
    for (const std::string& remark : plan->drawing.remarks) log().warning("{}", remark);
    LineMap map(*plan);
    if (map.left_out() > 0)
      log().warning("{}: {} lines are left out, since they are more than 1000 km away", path,
                    map.left_out());
    if (map.size() == 0) return refused(path + ": no lines");
    log().info("map {}: {} lines", path, map.size());
    const std::lock_guard lock(map_mutex_);
    std::swap(map_, map);
    unit_ = plan->placement.scale;
    begun_ = true;
    return {};
  }

  Result<void> save(std::string_view name) {
    std::string text;
    {
      const std::lock_guard lock(map_mutex_);
      text = map_.to_dxf(placement_for_saving());
    }
    const auto folder = FileFolder::of_messages();
    if (!folder) return folder.error();
    if (auto written = folder->write(name, text); !written) return written;
    log().info("map saved as {}", folder->path_of(name));
    return {};
  }

  OwnMailbox work_{*this, 1, body_max<PositionData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  std::atomic<bool> begun_ = false;  // the map is loaded; mapFile is ignored from now on
  PriorityMutex map_mutex_;
  LineMap map_;
  double unit_ = 1000;  // mm per unit of the plan that was loaded
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::FeatureMap map;
  return map.run(argc, argv);
}
