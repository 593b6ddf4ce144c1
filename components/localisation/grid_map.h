// A map as people and robots draw it: cells that are free, occupied or unknown. It comes from a
// ROS map file, from the walls of a floor plan, or from a message. Pure.
//
// The frame is that of RACK: x to the north, y to the east, mm. A row of cells lies along y. Walls
// are drawn by walking along them in steps of half a cell. A floor plan says nothing about what is
// free: what cannot be reached from outside without crossing a wall is taken for the inside; when
// the walls are not closed, everything between them is. Where a wall is within its cells is lost by
// that, so the walls are kept beside them for who has to know it better; and the wall farthest to
// the south and to the west goes through the middle of its cells, as plans have round numbers:
// on a border it would be drawn half a cell beside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/floor_map.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "tims/result.h"

namespace rack::localisation {

enum class Cell : std::uint8_t { kFree, kOccupied, kUnknown };

struct MapLine {
  MapPoint from;
  MapPoint to;
};

struct GridMap {
  double resolution = 50;  // mm
  MapPoint origin{};       // the corner of the first cell with the smallest x and y
  std::int32_t rows = 0;   // to the north
  std::int32_t columns = 0;
  std::vector<Cell> cells{};
  std::vector<MapLine> walls{};  // that they were drawn from; none: only the cells are known

  // 400 m x 400 m of 100 mm, or a kilometre of corridor 40 m wide of 50 mm.
  static constexpr std::int64_t kCellsMax = 16'000'000;

  [[nodiscard]] Cell at(std::int32_t row, std::int32_t column) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  }
  [[nodiscard]] std::size_t count(Cell cell) const;
};

// The walls with `margin` mm around them. Refused: no walls, walls that are no numbers, and more
// than kCellsMax cells.
tims::Result<GridMap> draw_walls(std::span<const MapLine> walls, double resolution,
                                 double margin = 500);
// As the classes of RACK have them.
tims::Result<GridMap> read_map(const DxfDrawing& drawing, double scale, double offset_x,
                               double offset_y, double resolution);
tims::Result<GridMap> read_map(const FeatureMapData& map, double resolution);
tims::Result<GridMap> read_map(const GridMapData& message);

// A map with more cells than a message has room for: as a whole with larger cells, of which one is
// occupied if any part of it is, or a part of it.
GridMap coarser(const GridMap& map, std::size_t cells_max);

struct GridPart {
  std::int32_t row = 0;
  std::int32_t column = 0;
  std::int32_t rows = 0;
  std::int32_t columns = 0;
  bool operator==(const GridPart&) const = default;
};
// A square of `side` cells with `around` in its middle third; the same until it leaves that.
GridPart part_around(const GridMap& map, const MapPoint& around, std::int32_t side);
// Not more cells than a message has; allocates nothing when it has its room.
void to_message(const GridMap& map, const GridPart& part, GridMapData& message);

}  // namespace rack::localisation
