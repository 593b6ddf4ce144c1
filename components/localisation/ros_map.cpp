#include "components/localisation/ros_map.h"

#include <cmath>

namespace rack::localisation {

GridMap grid_of(const RosMapInfo& info, const pictures::GreyPicture& picture) {
  GridMap map{.resolution = info.resolution * 1000,
              .origin = {info.origin_y * 1000, info.origin_x * 1000},
              .rows = picture.height,
              .columns = picture.width};
  const auto columns = static_cast<std::size_t>(map.columns);
  map.cells.resize(picture.values.size());
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const std::uint16_t value = picture.values[i];
    const double bright = static_cast<double>(value) / picture.white;
    // Raw values are per cent; above 100 is unknown.
    const double occupied = info.is_raw ? value / 100.0 : info.negate ? bright : 1 - bright;
    const bool is_unknown = info.is_raw && value > 100;
    const std::size_t row = static_cast<std::size_t>(map.rows) - 1 - i / columns;
    map.cells[row * columns + i % columns] = is_unknown                        ? Cell::kUnknown
                                             : occupied > info.occupied_thresh ? Cell::kOccupied
                                             : occupied < info.free_thresh     ? Cell::kFree
                                                                               : Cell::kUnknown;
  }
  return map;
}

pictures::GreyPicture grey_of(const GridMap& map) {
  // Grey values as ROS's map_saver writes them.
  constexpr std::uint16_t kBlack = 0;
  constexpr std::uint16_t kWhite = 254;
  constexpr std::uint16_t kGrey = 205;
  pictures::GreyPicture picture{.width = map.columns, .height = map.rows};
  picture.values.reserve(map.cells.size());
  for (std::int32_t row = map.rows - 1; row >= 0; --row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      const Cell cell = map.at(row, column);
      picture.values.push_back(cell == Cell::kOccupied ? kBlack
                               : cell == Cell::kFree   ? kWhite
                                                       : kGrey);
    }
  return picture;
}

Pose pose_of_ros(double x, double y, double theta) {
  return {.x = y * 1000, .y = x * 1000, .rho = kPi / 2 - theta};
}

RosPose ros_of_pose(const Pose& pose) {
  return {pose.y / 1000, pose.x / 1000, signed_angle(kPi / 2 - pose.rho)};
}

}  // namespace rack::localisation
