#include "components/localisation/grid_map.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "components/geometry/pose.h"

namespace rack::localisation {

namespace {

constexpr u8 kOccupiedFrom = 166;  // of 255: 65 %
constexpr u8 kFreeTo = 50;         // 20 %

tims::Error not_a_map(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

class Drawing {
 public:
  explicit Drawing(GridMap& map) : map_(map) {}

  void wall(const MapLine& line) {
    const double length = std::hypot(line.to.x - line.from.x, line.to.y - line.from.y);
    const std::int64_t steps = std::max(1L, std::lround(std::ceil(2 * length / map_.resolution)));
    for (std::int64_t i = 0; i <= steps; ++i) {
      const double part = static_cast<double>(i) / static_cast<double>(steps);
      cell(line.from.x + part * (line.to.x - line.from.x),
           line.from.y + part * (line.to.y - line.from.y)) = Cell::kOccupied;
    }
  }

  // Marks the cells that can be reached from the corners as unknown: they are outside of all walls.
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
  if (walls.empty()) return not_a_map("a map without walls");
  if (!(resolution >= 1)) return not_a_map("cells smaller than 1 mm");
  MapPoint low = walls[0].from;
  MapPoint high = low;
  for (const MapLine& wall : walls) {
    for (const MapPoint& end : {wall.from, wall.to}) {
      if (!std::isfinite(end.x) || !std::isfinite(end.y))
        return not_a_map("the end of a wall is not a number");
      low = {std::min(low.x, end.x), std::min(low.y, end.y)};
      high = {std::max(high.x, end.x), std::max(high.y, end.y)};
    }
  }
  margin = std::max(margin, 2 * resolution) + resolution / 2;
  const double rows = std::ceil((high.x - low.x + 2 * margin) / resolution);
  const double columns = std::ceil((high.y - low.y + 2 * margin) / resolution);
  if (!(rows * columns <= static_cast<double>(GridMap::kCellsMax)))
    return not_a_map("the walls are too far apart for cells of " +
                     std::to_string(static_cast<int>(resolution)) +
                     " mm: take larger cells, or check the scale of the plan");
  GridMap map{.resolution = resolution,
              .origin = {low.x - margin, low.y - margin},
              .rows = static_cast<std::int32_t>(rows),
              .columns = static_cast<std::int32_t>(columns),
              .walls = {walls.begin(), walls.end()}};
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
    return not_a_map("a grid map without cells");
  GridMap map{.resolution = static_cast<double>(message.scale),
              .origin = {static_cast<double>(message.offsetX) - message.scale / 2.0,
                         static_cast<double>(message.offsetY) - message.scale / 2.0},
              .rows = message.gridNumX,
              .columns = message.gridNumY};
  const auto rows = static_cast<std::size_t>(map.rows);
  const auto columns = static_cast<std::size_t>(map.columns);
  if (message.occupancy.size() != rows * columns)
    return not_a_map("a grid map whose number of cells is not rows times columns");
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

namespace {

// Occupied wins over free, free over unknown.
Cell cell_of(const GridMap& map, std::int32_t row, std::int32_t column, std::int32_t factor) {
  Cell found = Cell::kUnknown;
  for (std::int32_t r = row; r < std::min(row + factor, map.rows); ++r)
    for (std::int32_t c = column; c < std::min(column + factor, map.columns); ++c) {
      const Cell cell = map.at(r, c);
      if (cell == Cell::kOccupied) return cell;
      if (cell == Cell::kFree) found = cell;
    }
  return found;
}

}  // namespace

GridMap coarser(const GridMap& map, std::size_t cells_max) {
  std::int32_t factor = 1;
  const auto part = [&](std::int32_t count) { return (count + factor - 1) / factor; };
  while (static_cast<std::size_t>(part(map.rows)) * static_cast<std::size_t>(part(map.columns)) >
         cells_max)
    ++factor;
  GridMap made{.resolution = map.resolution * factor,
               .origin = map.origin,
               .rows = part(map.rows),
               .columns = part(map.columns)};
  made.cells.reserve(static_cast<std::size_t>(made.rows) * static_cast<std::size_t>(made.columns));
  for (std::int32_t row = 0; row < made.rows; ++row)
    for (std::int32_t column = 0; column < made.columns; ++column)
      made.cells.push_back(cell_of(map, row * factor, column * factor, factor));
  return made;
}

GridPart part_around(const GridMap& map, const MapPoint& around, std::int32_t side) {
  // Parts begin at multiples of a third of their side.
  const std::int32_t third = std::max(1, side / 3);
  const auto first = [&](double at, double origin, std::int32_t count) {
    const double cell = std::floor((at - origin) / map.resolution / third) * third - third;
    const double last = std::max(0, count - side);
    return static_cast<std::int32_t>(std::clamp(std::isfinite(cell) ? cell : 0.0, 0.0, last));
  };
  const std::int32_t row = first(around.x, map.origin.x, map.rows);
  const std::int32_t column = first(around.y, map.origin.y, map.columns);
  return {row, column, std::min(side, map.rows - row), std::min(side, map.columns - column)};
}

void to_message(const GridMap& map, const GridPart& part, GridMapData& message) {
  const auto middle = [&](double origin, std::int32_t cell) {
    return whole_millimetres(origin + (cell + 0.5) * map.resolution);
  };
  constexpr u8 kUnknownValue = 127;
  message.scale = whole_millimetres(map.resolution);
  message.offsetX = middle(map.origin.x, part.row);
  message.offsetY = middle(map.origin.y, part.column);
  message.gridNumX = part.rows;
  message.gridNumY = part.columns;
  message.occupancy.clear();
  for (std::int32_t column = part.column; column < part.column + part.columns; ++column)
    for (std::int32_t row = part.row; row < part.row + part.rows; ++row) {
      const Cell cell = map.at(row, column);
      message.occupancy.push_back(cell == Cell::kFree       ? u8{0}
                                  : cell == Cell::kOccupied ? u8{255}
                                                            : kUnknownValue);
    }
}

}  // namespace rack::localisation
