#include "components/localisation/grid_map.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "components/geometry/pose.h"

namespace rack::localisation {

namespace {

constexpr u8 kOccupiedFrom = 166;  // of 255: 65 %
constexpr u8 kFreeTo = 50;         // 20 %

tims::Error malformed(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

class Drawing {
 public:
  explicit Drawing(GridMap& map) : map_(map) {}

  void wall(const MapLine& line) {
    const double length = std::hypot(line.to.x - line.from.x, line.to.y - line.from.y);
    const double steps = std::max(1.0, std::ceil(2 * length / map_.resolution));
    for (double i = 0; i <= steps; ++i) {
      const double part = i / steps;
      cell(line.from.x + part * (line.to.x - line.from.x),
           line.from.y + part * (line.to.y - line.from.y)) = Cell::kOccupied;
    }
  }

  // Unknown becomes what can be reached from the corners, whose cells are outside of all walls.
  void fill_outside() {
    std::vector<std::size_t> edge{0};
    map_.cells[0] = Cell::kUnknown;
    while (!edge.empty()) {
      const std::size_t at = edge.back();
      edge.pop_back();
      const std::size_t columns = width();
      const std::size_t column = at % columns;
      if (column > 0) visit(at - 1, edge);
      if (column + 1 < columns) visit(at + 1, edge);
      if (at >= columns) visit(at - columns, edge);
      if (at + columns < map_.cells.size()) visit(at + columns, edge);
    }
  }

 private:
  [[nodiscard]] std::size_t width() const { return static_cast<std::size_t>(map_.columns); }
  Cell& cell(double x, double y) {
    const auto row = static_cast<std::size_t>((x - map_.origin.x) / map_.resolution);
    const auto column = static_cast<std::size_t>((y - map_.origin.y) / map_.resolution);
    return map_.cells[row * width() + column];
  }
  void visit(std::size_t at, std::vector<std::size_t>& edge) {
    if (map_.cells[at] != Cell::kFree) return;
    map_.cells[at] = Cell::kUnknown;
    edge.push_back(at);
  }

  GridMap& map_;
};

}  // namespace

std::size_t GridMap::count(Cell cell) const {
  return static_cast<std::size_t>(std::ranges::count(cells, cell));
}

tims::Result<GridMap> draw_walls(std::span<const MapLine> walls, double resolution, double margin) {
  if (walls.empty()) return malformed("a map without walls");
  if (!(resolution >= 1)) return malformed("cells smaller than 1 mm");
  MapPoint low = walls[0].from;
  MapPoint high = low;
  for (const MapLine& wall : walls) {
    for (const MapPoint& end : {wall.from, wall.to}) {
      if (!std::isfinite(end.x) || !std::isfinite(end.y))
        return malformed("the end of a wall is no number");
      low = {std::min(low.x, end.x), std::min(low.y, end.y)};
      high = {std::max(high.x, end.x), std::max(high.y, end.y)};
    }
  }
  margin = std::max(margin, 2 * resolution);
  const double rows = std::ceil((high.x - low.x + 2 * margin) / resolution);
  const double columns = std::ceil((high.y - low.y + 2 * margin) / resolution);
  if (!(rows * columns <= static_cast<double>(GridMap::kCellsMax)))
    return malformed("the walls are too far apart for cells of " +
                     std::to_string(static_cast<int>(resolution)) +
                     " mm: take larger cells, or check the scale of the plan");
  GridMap map{.resolution = resolution,
              .origin = {low.x - margin, low.y - margin},
              .rows = static_cast<std::int32_t>(rows),
              .columns = static_cast<std::int32_t>(columns)};
  map.cells.assign(static_cast<std::size_t>(rows * columns), Cell::kFree);
  Drawing drawing(map);
  for (const MapLine& wall : walls) drawing.wall(wall);
  GridMap closed = map;
  Drawing(closed).fill_outside();
  return closed.count(Cell::kFree) > 0 ? closed : map;
}

tims::Result<GridMap> read_map(const DxfDrawing& drawing, double scale, double offset_x,
                               double offset_y, double resolution) {
  std::vector<MapLine> walls;
  walls.reserve(drawing.lines.size());
  const auto point = [&](const DxfPoint& p) {
    return MapPoint{(p.y - offset_x) * scale, (p.x - offset_y) * scale};
  };
  for (const DxfLine& line : drawing.lines) walls.push_back({point(line.from), point(line.to)});
  return draw_walls(walls, resolution);
}

tims::Result<GridMap> read_map(const FeatureMapData& map, double resolution) {
  std::vector<MapLine> walls;
  for (const FeatureMapDataPoint& line : map.features)
    if (line.type == FeatureMapDataPoint::kLine)
      walls.push_back({{line.x.raw(), line.y.raw()}, {line.x2.raw(), line.y2.raw()}});
  return draw_walls(walls, resolution);
}

tims::Result<GridMap> read_map(const GridMapData& message) {
  if (message.scale <= 0 || message.gridNumX <= 0 || message.gridNumY <= 0)
    return malformed("a grid map without cells");
  GridMap map{.resolution = static_cast<double>(message.scale),
              .origin = {static_cast<double>(message.offsetX) - message.scale / 2.0,
                         static_cast<double>(message.offsetY) - message.scale / 2.0},
              .rows = message.gridNumX,
              .columns = message.gridNumY};
  const auto rows = static_cast<std::size_t>(map.rows);
  const auto columns = static_cast<std::size_t>(map.columns);
  if (message.occupancy.size() != rows * columns)
    return malformed("a grid map with another number of cells than it says");
  map.cells.resize(rows * columns);
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < columns; ++column) {
      const u8 value = message.occupancy[row + column * rows];  // x runs first
      map.cells[row * columns + column] = value >= kOccupiedFrom ? Cell::kOccupied
                                          : value <= kFreeTo     ? Cell::kFree
                                                                 : Cell::kUnknown;
    }
  return map;
}

tims::Result<GridMapData> to_message(const GridMap& map) {
  GridMapData message;
  if (map.cells.size() > decltype(message.occupancy)::kMax)
    return tims::Error(tims::Errc::kTooBig, std::to_string(map.cells.size()) +
                                                " cells: a grid map has at most " +
                                                std::to_string(decltype(message.occupancy)::kMax));
  message.scale = static_cast<i32>(std::lround(map.resolution));
  message.offsetX = static_cast<i32>(std::lround(map.origin.x + map.resolution / 2));
  message.offsetY = static_cast<i32>(std::lround(map.origin.y + map.resolution / 2));
  message.gridNumX = map.rows;
  message.gridNumY = map.columns;
  constexpr u8 kUnknownValue = 127;
  for (std::int32_t column = 0; column < map.columns; ++column)
    for (std::int32_t row = 0; row < map.rows; ++row) {
      const Cell cell = map.at(row, column);
      message.occupancy.push_back(cell == Cell::kFree       ? u8{0}
                                  : cell == Cell::kOccupied ? u8{255}
                                                            : kUnknownValue);
    }
  return message;
}

}  // namespace rack::localisation
