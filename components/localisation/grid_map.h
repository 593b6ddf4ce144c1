// An occupancy grid: cells are free, occupied or unknown. It is read from a ROS map file, from the
// walls of a floor plan, or from a message. Pure.
//
// The frame is that of RACK: x to the north, y to the east, mm. A row of cells runs along y. Walls
// are rasterised in steps of half a cell. A floor plan does not state what is free: cells that
// cannot be reached from outside without crossing a wall are inside, and free; when the walls are
// not closed, all cells between them are. Rasterising loses the exact positions of walls, so the
// lines are kept in `walls` for algorithms that need them. The southernmost and the westernmost
// wall pass through the middle of their cells: plans have round coordinates, and a wall on a cell
// border would be drawn half a cell off.
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
  MapPoint origin{};       // the corner of the first cell: smallest x and y
  std::int32_t rows = 0;   // to the north
  std::int32_t columns = 0;
  std::vector<Cell> cells{};
  std::vector<MapLine>
      walls{};  // lines that the cells were drawn from; empty: only cells are known

  // 400 m x 400 m with cells of 100 mm, or 1 km of corridor, 40 m wide, with cells of 50 mm.
  static constexpr std::int64_t kCellsMax = 16'000'000;

  [[nodiscard]] Cell at(std::int32_t row, std::int32_t column) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  }
  [[nodiscard]] std::size_t count(Cell cell) const;
};

// The walls with `margin` mm around them. Refused: no walls, coordinates that are not numbers, and
// more than kCellsMax cells.
tims::Result<GridMap> draw_walls(std::span<const MapLine> walls, double resolution,
                                 double margin = 500);
// From the map formats of RACK.
tims::Result<GridMap> read_map(const DxfDrawing& drawing, double scale, double offset_x,
                               double offset_y, double resolution);
tims::Result<GridMap> read_map(const FeatureMapData& map, double resolution);
tims::Result<GridMap> read_map(const GridMapData& message);

// A map reduced to `cells_max` cells by merging cells. A merged cell is occupied if any of its
// parts is.
GridMap coarser(const GridMap& map, std::size_t cells_max);

struct GridPart {
  std::int32_t row = 0;
  std::int32_t column = 0;
  std::int32_t rows = 0;
  std::int32_t columns = 0;
  bool operator==(const GridPart&) const = default;
};
// A square of `side` cells with `around` in its middle third. The result stays the same until
// `around` leaves that third.
GridPart part_around(const GridMap& map, const MapPoint& around, std::int32_t side);
// `part` must not have more cells than a message. Allocates nothing when the message has capacity.
void to_message(const GridMap& map, const GridPart& part, GridMapData& message);

}  // namespace rack::localisation
