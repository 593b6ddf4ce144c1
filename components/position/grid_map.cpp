// GridMap: a grid map, as a whole or the part around the robot.
#include <array>

#include "components/geometry/pose.h"
#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"
#include "rack/proxies/position.h"

namespace rack::navigation {
namespace {

constexpr std::array<ParameterInfo, 8> kParameters = {{
    host_file({"mapFile", "", "floor plan (DXF) or map of ROS (.yaml)", 0, 0, true}),
    kMapScaleFactor,
    kMapOffsetX,
    kMapOffsetY,
    kMapLayers,
    kMapResolution,
    optional_partner("position", "the position",
                     "the position; of large maps, only the part around it is sent; -1: the whole, "
                     "with larger cells"),
    {"period", 1000, "period of the data [ms]", 10, 60000},
}};

constexpr ModuleInfo kInfo{
    .program = "GridMap",
    .purpose = "A grid map, as a whole or the part around the robot.",
    .class_id = tims::class_id::kGridMap,
    .parameters = kParameters,
};

constexpr std::size_t kCellsMax = decltype(GridMapData::occupancy)::kMax;
constexpr std::int32_t kSide = 500;  // cells per side of a part: fills a data set

class GridMap : public DataModule<GridMapData> {
 public:
  GridMap() : DataModule(kInfo, {.history = 2}) {}

 private:
  Result<void> module_on() override {
    const std::string path = text("mapFile");
    auto map = load_map(path, placement(), integer("mapResolution"));
    if (!map) return map.error();
    for (const std::string& remark : map->remarks) log().warning("{}", remark);
    map_ = std::move(map->map);
    if (auto on = position_.turn_on(); !on) return on;
    if (!position_ && map_.cells.size() > kCellsMax) {
      map_ = localisation::coarser(map_, kCellsMax);
      log().info("{} has too many cells for a data set: sent with cells of {} mm", path,
                 map_.resolution);
    }
    part_ = {};
    if (!position_) send_part({0, 0, map_.rows, map_.columns});
    set_period(std::chrono::milliseconds(integer("period")));
    return DataModule::module_on();
  }

  [[nodiscard]] PlanPlacement placement() const {
    return {.scale = static_cast<double>(integer("mapScaleFactor")),
            .offset_x = static_cast<double>(integer("mapOffsetX")),
            .offset_y = static_cast<double>(integer("mapOffsetY")),
            .layers = text("mapLayers")};
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    if (position_) {
      const auto position = position_->get_data();
      if (!position) return position.error();
      const Pose robot = Pose::of(position->pos);
      send_part(localisation::part_around(map_, {robot.x, robot.y}, kSide));
    }
    get_local_buffer().recordingTime = time_stamp();
    return put_local_buffer();
  }

  void send_part(const localisation::GridPart& part) {
    if (part == part_) return;
    part_ = part;
    localisation::to_message(map_, part, get_local_buffer());
  }

  OwnMailbox work_{*this, 1, body_max<PositionData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  localisation::GridMap map_;
  localisation::GridPart part_;  // the part of the map in the local buffer
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::GridMap map;
  return map.run(argc, argv);
}
