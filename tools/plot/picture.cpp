#include "tools/plot/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "tools/plot/svg.h"

namespace rack::plot {

namespace {

using localisation::Cell;
using localisation::GridMap;

constexpr double kWidth = 1000;
constexpr double kLeft = 76;
constexpr double kRight = 24;
constexpr double kInner = kWidth - kLeft - kRight;
constexpr double kMapHeightMax = 760;
constexpr double kMapHeightMin = 260;
constexpr double kSeriesHeight = 150;
constexpr double kBelow = 52;  // height of an axis with its labels
constexpr double kLegendLine = 22;
constexpr double kLetter = 7.8;  // width of a letter at 13 pixels
constexpr const char* kGrid = "#e4e4e4";
constexpr const char* kWall = "#555555";

struct Look {
  const char* colour;
  const char* dashes;
  double width;
};
Look look_of(Role role) {
  switch (role) {
    case Role::kEstimate:
      return {"#0072b2", "", 1.6};
    case Role::kOdometry:
      return {"#e69f00", "7 3", 1.5};
    case Role::kTruth:
      return {"#7fd1b9", "", 4.5};  // wide and pale: other lines remain visible on it
    case Role::kPath:
      return {"#d55e00", "10 3 2 3", 1.8};
    default:
      return {"#cc79a7", "", 1.5};
  }
}

// Further lines of the same role use the remaining colours.
std::vector<Look> looks_of(const std::vector<Role>& roles) {
  constexpr std::array<Look, 4> kMore = {
      {{"#56b4e9", "4 2", 1.8}, {"#000000", "", 1.2}, {"#cc79a7", "9 3", 1.8}, {"#f0e442", "", 2}}};
  std::vector<Look> looks;
  std::size_t more = 0;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const bool again = std::ranges::find(roles.begin(), roles.begin() + static_cast<long>(i),
                                         roles[i]) != roles.begin() + static_cast<long>(i);
    looks.push_back(again ? kMore[more++ % kMore.size()] : look_of(roles[i]));
  }
  return looks;
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double size() const { return high - low; }
  // Widened to at least `least`, with a small margin around the values.
  void widen(double least) {
    if (!(high >= low)) low = high = 0;
    const double more = std::max(0.03 * size(), (least - size()) / 2);
    low -= more;
    high += more;
  }
  void stretch(double to) {
    const double more = std::max(0.0, to - size()) / 2;
    low -= more;
    high += more;
  }
};

std::string tick_text(double value, double step) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  const std::string text = fmt::format("{:.{}f}", value, digits);
  return value == 0 || text.find_first_not_of("-0.") == std::string::npos ? "0" : text;
}

// Maps values to positions in the picture.
struct Axes {
  Box box;
  Range across;
  Range up;

  [[nodiscard]] Spot spot(double x, double y) const {
    return {box.x + (x - across.low) / across.size() * box.width,
            box.y + box.height - (y - up.low) / up.size() * box.height};
  }
};

void draw_axes(Canvas& canvas, const Axes& axes, const std::string& across, const std::string& up,
               int rows) {
  const Box& box = axes.box;
  const auto columns = ticks(axes.across.low, axes.across.high, 9);
  for (const double x : columns) {
    const Spot at = axes.spot(x, axes.up.low);
    canvas.line({at.x, box.y}, at, {.colour = kGrid});
    const double step = columns.size() > 1 ? columns[1] - columns[0] : 1;
    canvas.text({at.x, at.y + 18}, tick_text(x, step), {.size = 13, .anchor = Anchor::kMiddle});
  }
  const auto lines = ticks(axes.up.low, axes.up.high, rows);
  for (const double y : lines) {
    const Spot at = axes.spot(axes.across.low, y);
    canvas.line(at, {box.x + box.width, at.y}, {.colour = kGrid});
    const double step = lines.size() > 1 ? lines[1] - lines[0] : 1;
    canvas.text({at.x - 7, at.y + 4.5}, tick_text(y, step), {.size = 13, .anchor = Anchor::kEnd});
  }
  canvas.frame(box, {.colour = "#888888"});
  canvas.text({box.x + box.width / 2, box.y + box.height + 38}, across,
              {.size = 14, .anchor = Anchor::kMiddle});
  canvas.text({18, box.y + box.height / 2}, up,
              {.size = 14, .anchor = Anchor::kMiddle, .upwards = true});
}

// --- the map

// In metres: `across` is y of RACK, `up` is x.
void add_points(const std::vector<MapPoint>& points, Range& across, Range& up) {
  for (const MapPoint& point : points) {
    across.add(point.y / 1000);
    up.add(point.x / 1000);
  }
}

void add_map(const GridMap& map, Range& across, Range& up) {
  for (std::int32_t row = 0; row < map.rows; ++row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      if (map.at(row, column) == Cell::kUnknown) continue;
      across.add((map.origin.y + column * map.resolution) / 1000);
      up.add((map.origin.x + row * map.resolution) / 1000);
    }
}

Axes map_axes(const Picture& picture, double top) {
  Axes axes;
  if (picture.map) add_map(*picture.map, axes.across, axes.up);
  for (const Trajectory& trajectory : picture.trajectories)
    add_points(trajectory.points, axes.across, axes.up);
  add_points(picture.dots, axes.across, axes.up);
  for (const Mark& mark : picture.marks) add_points({{mark.at.x, mark.at.y}}, axes.across, axes.up);
  axes.across.widen(2);
  axes.up.widen(2);
  const double height =
      std::clamp(kInner * axes.up.size() / axes.across.size(), kMapHeightMin, kMapHeightMax);
  axes.box = {kLeft, top, kInner, height};
  // Both axes have the same scale.
  axes.across.stretch(axes.up.size() * kInner / height);
  axes.up.stretch(axes.across.size() * height / kInner);
  return axes;
}

std::vector<CellRun> walls_of(const GridMap& map) {
  std::vector<CellRun> runs;
  for (std::int32_t row = 0; row < map.rows; ++row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      if (map.at(row, column) != Cell::kOccupied) continue;
      const std::int32_t first = column;
      while (column < map.columns && map.at(row, column) == Cell::kOccupied) ++column;
      runs.push_back({map.rows - 1 - row, first, column - first});
    }
  return runs;
}

void draw_map(Canvas& canvas, const GridMap& map, const Axes& axes) {
  // At most one cell per pixel.
  const double pixel = axes.across.size() * 1000 / axes.box.width;  // mm
  const double wanted = std::max(1.0, pixel / map.resolution);
  const double cells = static_cast<double>(map.cells.size()) / (wanted * wanted);
  const GridMap shown = localisation::coarser(map, static_cast<std::size_t>(std::ceil(cells)) + 1);
  const Spot left_top =
      axes.spot(shown.origin.y / 1000, (shown.origin.x + shown.rows * shown.resolution) / 1000);
  canvas.cells(walls_of(shown), left_top, shown.resolution / pixel, kWall);
}

std::vector<Spot> spots_of(const Trajectory& trajectory, const Axes& axes) {
  std::vector<Spot> spots;
  for (const MapPoint& point : trajectory.points)
    if (std::isfinite(point.x) && std::isfinite(point.y))
      spots.push_back(axes.spot(point.y / 1000, point.x / 1000));
  return spots;
}

void draw_mark(Canvas& canvas, const Mark& mark, const Axes& axes) {
  const Spot at = axes.spot(mark.at.y / 1000, mark.at.x / 1000);
  const Look look = look_of(mark.role);
  const Spot tip{at.x + 16 * std::sin(mark.at.rho), at.y - 16 * std::cos(mark.at.rho)};
  canvas.dot(at, 6, "#ffffff", 1);
  canvas.dot(at, 5, look.colour, 1);
  canvas.line(at, tip, {.colour = look.colour, .width = 3});
  if (!mark.name.empty())
    canvas.text({at.x + 10, at.y + 18}, mark.name,
                {.size = 13, .colour = look.colour, .bold = true});
}

void draw_ground(Canvas& canvas, const Picture& picture, const std::vector<Look>& looks,
                 const Axes& axes) {
  canvas.area(axes.box, "#ffffff");
  draw_axes(canvas, axes, "y, to the east [m]", "x, to the north [m]", 7);
  canvas.clip(axes.box);
  if (picture.map) draw_map(canvas, *picture.map, axes);
  for (const MapPoint& dot : picture.dots)
    canvas.dot(axes.spot(dot.y / 1000, dot.x / 1000), 1.5, "#56b4e9", 0.6);
  constexpr std::array kOrder = {Role::kTruth, Role::kOdometry, Role::kOther, Role::kPath,
                                 Role::kEstimate};
  for (const Role role : kOrder)
    for (std::size_t i = 0; i < picture.trajectories.size(); ++i) {
      if (picture.trajectories[i].role != role) continue;
      const Look& look = looks[i];
      canvas.lines(spots_of(picture.trajectories[i], axes),
                   {.colour = look.colour, .width = look.width, .dashes = look.dashes});
    }
  for (const Mark& mark : picture.marks) draw_mark(canvas, mark, axes);
  canvas.end_clip();
}

// --- legends

struct Entry {
  std::string name;
  Look look;
};

// Returns the height; draws only if `canvas` is given.
double legend(Canvas* canvas, const std::vector<Entry>& entries, double top) {
  double x = kLeft;
  double y = top;
  for (const Entry& entry : entries) {
    const double wide = 44 + kLetter * static_cast<double>(entry.name.size());
    if (x > kLeft && x + wide > kWidth - kRight) {
      x = kLeft;
      y += kLegendLine;
    }
    if (canvas != nullptr) {
      canvas->line({x, y + 10}, {x + 30, y + 10},
                   {.colour = entry.look.colour,
                    .width = entry.look.width + 0.5,
                    .dashes = entry.look.dashes});
      canvas->text({x + 36, y + 15}, entry.name, {.size = 13});
    }
    x += wide + 14;
  }
  return entries.empty() ? 0 : y - top + kLegendLine + 4;
}

std::vector<Entry> entries_of(const Picture& picture, const std::vector<Look>& looks) {
  std::vector<Entry> entries;
  if (picture.map) entries.push_back({"map", {kWall, "", 4}});
  for (std::size_t i = 0; i < picture.trajectories.size(); ++i)
    entries.push_back({picture.trajectories[i].name, looks[i]});
  if (!picture.dots.empty()) entries.push_back({"samples", {"#56b4e9", "2 3", 3}});
  return entries;
}

// --- diagrams over time

std::vector<std::string> units_of(const std::vector<Series>& series) {
  std::vector<std::string> units;
  for (const Series& one : series)
    if (std::ranges::find(units, one.unit) == units.end()) units.push_back(one.unit);
  return units;
}

std::vector<const Series*> of_unit(const std::vector<Series>& series, const std::string& unit) {
  std::vector<const Series*> out;
  for (const Series& one : series)
    if (one.unit == unit) out.push_back(&one);
  return out;
}

void draw_series(Canvas& canvas, const std::vector<const Series*>& series, double begin,
                 double top) {
  std::vector<Role> roles;
  Axes axes;
  axes.up.add(0);
  std::string name = series.front()->name;
  for (const Series* one : series) {
    roles.push_back(one->role);
    if (one->name != name) name.clear();
    for (const double time : one->times) axes.across.add(time - begin);
    for (const double value : one->values) axes.up.add(value);
  }
  axes.across.widen(1);
  const bool never_negative = axes.up.low == 0;
  axes.up.widen(1e-6);
  if (never_negative) axes.up.low = 0;
  const auto looks = looks_of(roles);
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < series.size(); ++i) entries.push_back({series[i]->name, looks[i]});
  const double high = legend(&canvas, entries, top);
  axes.box = {kLeft, top + high, kInner, kSeriesHeight};
  draw_axes(canvas, axes, "time [s]", "[" + series.front()->unit + "]", 4);
  canvas.clip(axes.box);
  for (std::size_t i = 0; i < series.size(); ++i) {
    std::vector<Spot> spots;
    for (std::size_t k = 0; k < series[i]->values.size(); ++k)
      if (std::isfinite(series[i]->values[k]))
        spots.push_back(axes.spot(series[i]->times[k] - begin, series[i]->values[k]));
    canvas.lines(spots, {.colour = looks[i].colour, .width = 1.4, .dashes = looks[i].dashes});
  }
  canvas.end_clip();
}

double height_of(const std::vector<const Series*>& series) {
  std::vector<Entry> entries;
  entries.reserve(series.size());
  for (const Series* one : series) entries.push_back({one->name, look_of(one->role)});
  return legend(nullptr, entries, 0) + kSeriesHeight + kBelow;
}

bool has_ground(const Picture& picture) {
  return picture.map || !picture.trajectories.empty() || !picture.dots.empty() ||
         !picture.marks.empty();
}

// --- errors

// The interpolated position at a time; empty before the start and after the end.
std::optional<MapPoint> at(const Trajectory& trajectory, double time) {
  const auto after = std::ranges::lower_bound(trajectory.times, time);
  if (after == trajectory.times.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - trajectory.times.begin());
  if (trajectory.times[i] == time) return trajectory.points[i];
  if (i == 0) return std::nullopt;
  const double part =
      (time - trajectory.times[i - 1]) / (trajectory.times[i] - trajectory.times[i - 1]);
  const MapPoint& a = trajectory.points[i - 1];
  const MapPoint& b = trajectory.points[i];
  return MapPoint{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
}

bool has_times(const Trajectory& trajectory) {
  return trajectory.times.size() == trajectory.points.size() &&
         std::ranges::is_sorted(trajectory.times);
}

}  // namespace

std::vector<double> ticks(double low, double high, int about) {
  const double wanted = (high - low) / std::max(1, about);
  if (!(wanted > 0) || !std::isfinite(wanted)) return {};
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double part = wanted / power;
  const double step = power * (part <= 1 ? 1 : part <= 2 ? 2 : part <= 5 ? 5 : 10);
  std::vector<double> out;
  const double first = std::ceil(low / step);
  for (int i = 0; i < 100 && (first + i) * step <= high; ++i) out.push_back((first + i) * step);
  return out;
}

std::vector<Series> errors_of(const std::vector<Trajectory>& trajectories) {
  const auto truth = std::ranges::find_if(trajectories, [](const Trajectory& trajectory) {
    return trajectory.role == Role::kTruth && !trajectory.times.empty() && has_times(trajectory);
  });
  std::vector<Series> errors;
  if (truth == trajectories.end()) return errors;
  for (const Trajectory& trajectory : trajectories) {
    if (trajectory.role == Role::kTruth || trajectory.role == Role::kPath || !has_times(trajectory))
      continue;
    Series error{trajectory.name + ": position error", "m", trajectory.role};
    for (std::size_t i = 0; i < trajectory.times.size(); ++i) {
      const auto should = at(*truth, trajectory.times[i]);
      if (!should) continue;
      error.times.push_back(trajectory.times[i]);
      error.values.push_back(
          std::hypot(trajectory.points[i].x - should->x, trajectory.points[i].y - should->y) /
          1000);
    }
    if (!error.times.empty()) errors.push_back(std::move(error));
  }
  return errors;
}

namespace {

// What is where: the picture is laid out before there is a canvas, whose size it determines.
struct Layout {
  explicit Layout(const Picture& picture)
      : looks(looks_of(roles_of(picture))),
        entries(entries_of(picture, looks)),
        title(picture.title.empty() ? 14 : 44),
        axes(map_axes(picture, title + legend(nullptr, entries, title))),
        units(units_of(picture.series)) {
    ground_end = has_ground(picture) ? axes.box.y + axes.box.height + kBelow : title;
    height = ground_end + 8;
    for (const std::string& unit : units) height += height_of(of_unit(picture.series, unit));
  }

  static std::vector<Role> roles_of(const Picture& picture) {
    std::vector<Role> roles;
    roles.reserve(picture.trajectories.size());
    for (const Trajectory& trajectory : picture.trajectories) roles.push_back(trajectory.role);
    return roles;
  }

  std::vector<Look> looks;
  std::vector<Entry> entries;
  double title;
  Axes axes;
  std::vector<std::string> units;
  double ground_end = 0;
  double height = 0;
};

void draw_on(Canvas& canvas, const Picture& picture, const Layout& layout) {
  if (!picture.title.empty()) canvas.text({kLeft, 30}, picture.title, {.size = 19, .bold = true});
  if (has_ground(picture)) {
    legend(&canvas, layout.entries, layout.title);
    draw_ground(canvas, picture, layout.looks, layout.axes);
  }
  double begin = std::numeric_limits<double>::infinity();
  for (const Series& one : picture.series)
    for (const double time : one.times) begin = std::min(begin, time);
  double top = layout.ground_end;
  for (const std::string& unit : layout.units) {
    const auto series = of_unit(picture.series, unit);
    draw_series(canvas, series, begin, top);
    top += height_of(series);
  }
}

}  // namespace

std::string to_svg(const Picture& picture) {
  const Layout layout(picture);
  Svg svg(kWidth, layout.height);
  draw_on(svg, picture, layout);
  return std::move(svg).finish();
}

tims::Result<std::string> to_png(const Picture& picture, pictures::DrawPng draw_png) {
  const Layout layout(picture);
  tims::Result<std::string> png = std::string();
  draw_png(
      kWidth, layout.height, [&](Canvas& canvas) { draw_on(canvas, picture, layout); }, png);
  return png;
}

}  // namespace rack::plot
