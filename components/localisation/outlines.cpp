#include "components/localisation/outlines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "components/geometry/pose.h"

namespace rack::localisation {

namespace {

// In cells, from the corner of the first cell.
struct Corner {
  std::int32_t row = 0;
  std::int32_t column = 0;
  bool operator==(const Corner&) const = default;
};

double length(const Corner& from, const Corner& to) {
  return std::hypot(to.row - from.row, to.column - from.column);
}

// Follows the borders between occupied cells and others. Directions are numbered from that of the
// columns (0) over that of the rows (1) on, counter-clockwise.
class BorderWalk {
 public:
  explicit BorderWalk(const GridMap& map) : map_(map), seen_(map.cells.size()) {}

  // The closed outlines, one after the other: true until `take` returns false.
  template <typename Take>
  bool all(const Take& take) {
    for (std::int32_t row = 0; row < map_.rows; ++row)
      for (std::int32_t column = 0; column < map_.columns; ++column) {
        if (!is_wall(row, column)) continue;
        for (int direction = 0; direction < 4; ++direction) {
          const Step start = step_along({row, column}, direction);
          if (is_border(start) && !is_seen(start) && !take(follow(start))) return false;
        }
      }
    return true;
  }

 private:
  struct Step {
    Corner from;
    int direction = 0;
  };
  static constexpr std::array<Corner, 4> kAhead = {Corner{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  // The cells to the left and to the right of a step, relative to the corner where it begins.
  static constexpr std::array<Corner, 4> kLeft = {Corner{0, 0}, {0, -1}, {-1, -1}, {-1, 0}};
  static constexpr std::array<Corner, 4> kRight = {Corner{-1, 0}, {0, 0}, {0, -1}, {-1, -1}};

  static Corner sum(const Corner& a, const Corner& b) {
    return {a.row + b.row, a.column + b.column};
  }
  [[nodiscard]] bool is_wall(std::int32_t row, std::int32_t column) const {
    return row >= 0 && column >= 0 && row < map_.rows && column < map_.columns &&
           map_.at(row, column) == Cell::kOccupied;
  }
  [[nodiscard]] bool is_wall(const Corner& cell) const { return is_wall(cell.row, cell.column); }
  // The step that has this cell on its left.
  static Step step_along(const Corner& cell, int direction) {
    const Corner& left = kLeft[static_cast<std::size_t>(direction)];
    return {{cell.row - left.row, cell.column - left.column}, direction};
  }
  static Corner left_of(const Step& step) {
    return sum(step.from, kLeft[static_cast<std::size_t>(step.direction)]);
  }
  static Corner right_of(const Step& step) {
    return sum(step.from, kRight[static_cast<std::size_t>(step.direction)]);
  }
  [[nodiscard]] bool is_border(const Step& step) const {
    return is_wall(left_of(step)) && !is_wall(right_of(step));
  }
  std::uint8_t& seen(const Step& step) {
    const Corner cell = left_of(step);
    return seen_[static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(map_.columns) +
                 static_cast<std::size_t>(cell.column)];
  }
  bool is_seen(const Step& step) { return (seen(step) >> step.direction & 1) != 0; }

  // The corners at which the outline turns, beginning with one of them.
  std::vector<Corner> follow(Step step) {
    std::vector<Corner> corners;
    while (!is_seen(step)) {
      seen(step) = static_cast<std::uint8_t>(seen(step) | 1 << step.direction);
      const Step ahead{sum(step.from, kAhead[static_cast<std::size_t>(step.direction)]),
                       step.direction};
      // To the right first: there is a cell that touches at the corner only.
      const int turn = is_wall(right_of(ahead)) ? 3 : is_wall(left_of(ahead)) ? 0 : 1;
      step = {ahead.from, (ahead.direction + turn) % 4};
      if (turn != 0) corners.push_back(step.from);
    }
    return corners;
  }

  const GridMap& map_;
  std::vector<std::uint8_t> seen_;  // steps by the cell on their left: a bit for each direction
};

// The points of an outline, in half cells.
std::vector<Corner> points_of(std::span<const Corner> corners) {
  const std::size_t count = corners.size();
  const auto is_short = [&](std::size_t run) {  // from this corner to the next
    return length(corners[run % count], corners[(run + 1) % count]) < 1.5;
  };
  std::vector<Corner> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& from = corners[i];
    const Corner& to = corners[(i + 1) % count];
    if (is_short(i))
      points.push_back({from.row + to.row, from.column + to.column});
    else if (!is_short(i + count - 1))
      points.push_back({2 * from.row, 2 * from.column});
  }
  return points;
}

// The directions from a point that pass all others so far within the tolerance.
class Sector {
 public:
  Sector(const Corner& from, double tolerance) : from_(from), tolerance_(tolerance) {}

  // Narrows the sector. False: no line from the corner passes all points.
  bool take(const Corner& point) {
    const double away = length(from_, point);
    if (away < farthest_ - tolerance_) return false;  // the outline turns back
    contains_last_ = away >= farthest_;
    farthest_ = std::max(farthest_, away);
    if (away <= tolerance_) return true;
    const double angle = std::atan2(point.row - from_.row, point.column - from_.column);
    const double half = std::asin(tolerance_ / away);
    if (!std::exchange(has_middle_, true)) middle_ = angle;
    const double offset = signed_angle(angle - middle_);
    contains_last_ = contains_last_ && offset >= low_ && offset <= high_;
    low_ = std::max(low_, offset - half);
    high_ = std::min(high_, offset + half);
    return low_ <= high_;
  }
  // Whether a line to the last point passes all others.
  [[nodiscard]] bool contains_last() const { return contains_last_; }

 private:
  Corner from_;
  double tolerance_;
  double farthest_ = 0;
  bool has_middle_ = false;
  double middle_ = 0;
  double low_ = -kPi;  // offsets from the middle
  double high_ = kPi;
  bool contains_last_ = false;
};

using Line = std::pair<Corner, Corner>;

// In cells. With the first one, a single cell keeps its four sides.
constexpr std::array<double, 4> kTolerances = {0.45, 1, 2, 3};

// The number of points of a line is bounded, since those behind its end are looked at again.
constexpr std::size_t kPointsOfLine = 256;

// `points` and `tolerance` are in half cells.
void simplify(std::span<const Corner> points, double tolerance, std::vector<Line>& lines) {
  const std::size_t count = points.size();
  const auto at = [&](std::size_t i) { return points[i % count]; };
  const std::size_t before = lines.size();
  for (std::size_t from = 0; from < count;) {
    Sector sector(at(from), tolerance);
    std::size_t to = from + 1;
    const std::size_t last = std::min(count, from + kPointsOfLine);
    for (std::size_t i = from + 1; i <= last && sector.take(at(i)); ++i)
      if (sector.contains_last()) to = i;
    if (!(at(from) == at(to))) lines.emplace_back(at(from), at(to));
    from = to;
  }
  const std::size_t made = lines.size() - before;
  if (made == 2 && lines.back().first == lines[before].second) lines.pop_back();  // there and back
  if (made > 1) return;
  // A group as small as the tolerance is a line through it.
  lines.resize(before);
  const auto farthest = std::ranges::max_element(
      points, {}, [&](const Corner& point) { return length(points.front(), point); });
  lines.emplace_back(points.front(), *farthest);
}

tims::Error no_lines(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

}  // namespace

tims::Result<Outlines> outlines(const GridMap& map, std::size_t lines_max) {
  std::vector<std::vector<Corner>> all;
  std::size_t corners = 0;
  const bool is_complete = BorderWalk(map).all([&](std::vector<Corner> outline) {
    corners += outline.size();
    all.push_back(points_of(outline));
    return corners <= kOutlineCornersMax;
  });
  if (all.empty()) return no_lines("the map has no occupied cells");
  std::vector<Line> lines;
  constexpr double kMiddles = 0.5;  // cells: from the middle of a run to its ends
  for (const double tolerance : kTolerances) {
    lines.clear();
    for (const auto& outline : all)
      if (lines.size() <= lines_max) simplify(outline, 2 * tolerance, lines);
    if (!is_complete || lines.size() > lines_max) continue;
    Outlines made{.lines = {},
                  .error = (tolerance + kMiddles) * map.resolution,
                  .is_coarse = tolerance > kTolerances[0]};
    const auto point = [&](const Corner& half_cells) {
      return MapPoint{map.origin.x + half_cells.row * map.resolution / 2,
                      map.origin.y + half_cells.column * map.resolution / 2};
    };
    for (const auto& [from, to] : lines) made.lines.push_back({point(from), point(to)});
    return made;
  }
  return no_lines("the outlines of its walls are more than " + std::to_string(lines_max) +
                  " lines, also with an error of 3 cells: remove noise, use larger cells, or crop "
                  "the map");
}

}  // namespace rack::localisation
