#include "tools/plot/trajectory_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/text.h"
#include "components/localisation/carmen_log.h"
#include "components/localisation/ros_map.h"
#include "components/path/polar_spline.h"

namespace rack::plot {

namespace {

using std::string_view;
using tims::Result;
using tims::base::trimmed;

constexpr std::size_t kColumnsMax = 4096;

tims::Error malformed(const std::string& what) { return {tims::Errc::kMalformed, what}; }
tims::Error wrong(std::size_t line, const std::string& what) {
  return malformed("line " + std::to_string(line) + ": " + what);
}

Role role_of(string_view name) {
  const std::string low = tims::base::lower(name);
  const auto is = [&](string_view begin) { return low.starts_with(begin); };
  if (is("truth") || is("true")) return Role::kTruth;
  if (is("odometry")) return Role::kOdometry;
  if (is("path")) return Role::kPath;
  if (is("position") || is("mcl") || is("estimate") || is("pilot")) return Role::kEstimate;
  return Role::kOther;
}

// --- lines and fields

string_view take_line(string_view& text) {
  const auto end = text.find('\n');
  string_view line = text.substr(0, end);
  text.remove_prefix(end == string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

constexpr string_view kMarks = " \t\"";  // stripped from fields

// Fields between commas or semicolons may be empty; fields between blanks may not.
std::vector<string_view> fields_of(string_view line, char between) {
  std::vector<string_view> fields;
  if (between != ' ') {
    for (;;) {
      const auto end = line.find(between);
      fields.push_back(trimmed(line.substr(0, end), kMarks));
      if (end == string_view::npos || fields.size() == kColumnsMax) return fields;
      line.remove_prefix(end + 1);
    }
  }
  constexpr string_view kBlank = " \t";
  for (;;) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
    if (line.empty()) return fields;
    const string_view field = line.substr(0, line.find_first_of(kBlank));
    fields.push_back(field);
    line.remove_prefix(field.size());
  }
}

char separator_of(string_view line) {
  if (line.find(',') != string_view::npos) return ',';
  return line.find(';') != string_view::npos ? ';' : ' ';
}

std::optional<double> number_of(string_view field) {
  const auto value = tims::base::parse_number<double>(field);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// --- named columns

struct TrajectoryColumns {
  std::string name{};  // prefix of the column names
  std::size_t x = 0;
  std::size_t y = 0;
  double factor = 1;  // to mm
};
struct SeriesColumn {
  std::size_t index = 0;
  double factor = 1;
  Series series{};
};

class Table {
 public:
  Table(std::span<const string_view> columns, string_view own_name, string_view title)
      : own_name_(own_name), title_(title) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] == "time_s" || columns[i] == "t_s") set_time(i, 1);
      if (columns[i] == "time_ms" || columns[i] == "recordingTime") set_time(i, 1e-3);
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      find_trajectory(columns, i);
      find_series(columns[i], i);
    }
  }

  [[nodiscard]] bool empty() const { return trajectories_.empty() && series_.empty(); }

  Result<void> add(std::span<const string_view> fields, std::size_t line) {
    const auto at = [&](std::size_t column) -> std::optional<double> {
      return column < fields.size() ? number_of(fields[column]) : std::nullopt;
    };
    for (std::size_t i = 0; i < fields.size(); ++i)
      if (is_used(i) && !fields[i].empty() && !at(i))
        return wrong(line, "\"" + std::string(fields[i].substr(0, 20)) + "\" is not a number");
    const auto clock = time_column_ < kColumnsMax ? at(time_column_) : std::nullopt;
    const double time = clock.value_or(0) * time_factor_;
    for (std::size_t i = 0; i < trajectories_.size(); ++i) {
      const auto x = at(columns_[i].x);
      const auto y = at(columns_[i].y);
      if (!x || !y) continue;
      trajectories_[i].points.push_back({*x * columns_[i].factor, *y * columns_[i].factor});
      if (clock) trajectories_[i].times.push_back(time);
    }
    for (SeriesColumn& column : series_) {
      const auto value = at(column.index);
      if (!value || !clock) continue;
      column.series.times.push_back(time);
      column.series.values.push_back(*value * column.factor);
    }
    return {};
  }

  void move_to(Picture& picture) {
    for (Trajectory& trajectory : trajectories_)
      if (!trajectory.points.empty()) picture.trajectories.push_back(std::move(trajectory));
    for (SeriesColumn& column : series_)
      if (!column.series.values.empty()) picture.series.push_back(std::move(column.series));
  }

 private:
  [[nodiscard]] bool is_used(std::size_t column) const {
    const bool of_trajectory = std::ranges::any_of(
        columns_, [&](const TrajectoryColumns& c) { return c.x == column || c.y == column; });
    return of_trajectory || time_column_ == column ||
           std::ranges::any_of(series_, [&](const auto& s) { return s.index == column; });
  }

  void set_time(std::size_t column, double factor) {
    time_column_ = column;
    time_factor_ = factor;
  }

  // Finds a pair of columns whose x is column i: "truth_x_m" and "truth_y_m", "x_m", "pos.x".
  void find_trajectory(std::span<const string_view> columns, std::size_t i) {
    constexpr std::array<std::pair<string_view, string_view>, 3> kPairs = {
        {{"x_m", "y_m"}, {"x_mm", "y_mm"}, {"pos.x", "pos.y"}}};
    for (const auto& [x, y] : kPairs) {
      if (!columns[i].ends_with(x)) continue;
      const string_view before = columns[i].substr(0, columns[i].size() - x.size());
      const bool whole = before.empty() || (before.back() == '_' && x != "pos.x");
      if (!whole) continue;
      const auto other = std::ranges::find(columns, std::string(before) + std::string(y));
      if (other == columns.end()) continue;
      add_trajectory(before.empty() ? before : before.substr(0, before.size() - 1), i,
                     static_cast<std::size_t>(other - columns.begin()), x == "x_m" ? 1000 : 1);
    }
  }

  void add_trajectory(string_view before, std::size_t x, std::size_t y, double factor) {
    Trajectory trajectory;
    trajectory.name = own_name_.empty() ? title_ : own_name_;
    if (trajectory.name.empty()) trajectory.name = "estimate";
    trajectory.role = role_of(trajectory.name);
    if (!before.empty()) {
      trajectory.role = role_of(before);
      trajectory.name =
          own_name_.empty() ? before : std::string(own_name_) + " " + std::string(before);
    }
    trajectories_.push_back(std::move(trajectory));
    columns_.push_back({std::string(before), x, y, factor});
  }

  void find_series(string_view column, std::size_t i) {
    struct Known {
      string_view end;
      const char* unit;
      double factor;
    };
    constexpr std::array<Known, 6> kKnown = {{{"error_m", "m", 1},
                                              {"error_deg", "degrees", 1},
                                              {"error_mm", "m", 1e-3},
                                              {"speed_mps", "m/s", 1},
                                              {"speed", "m/s", 1e-3},
                                              {"vx", "m/s", 1e-3}}};
    for (const Known& known : kKnown) {
      const bool bare = known.end == "speed" || known.end == "vx";
      if (bare ? column != known.end : !column.ends_with(known.end)) continue;
      const string_view what =
          column.substr(0, column.size() - (bare ? 0 : known.end.size() - known.end.find('_')));
      const bool turn = std::string_view(known.unit) == "degrees";
      std::string name(what == "vx" ? "speed" : what);
      if (what == "error") name = turn ? "heading error" : "position error";
      const std::string whose = own_name_.empty() ? title_ : own_name_;
      if (!whose.empty()) name.insert(0, whose + ": ");
      series_.push_back({i,
                         known.factor,
                         {.name = std::move(name), .unit = known.unit, .role = Role::kEstimate}});
      return;
    }
  }

  std::string own_name_;
  std::string title_;
  std::size_t time_column_ = kColumnsMax;  // kColumnsMax: none
  double time_factor_ = 1;                 // to s
  std::vector<Trajectory> trajectories_;
  std::vector<TrajectoryColumns> columns_;  // of each trajectory
  std::vector<SeriesColumn> series_;
};

Result<void> add_table(string_view text, string_view name, std::size_t line,
                       std::span<const string_view> columns, string_view title, char between,
                       Picture& picture) {
  Table table(columns, name, title);
  if (table.empty())
    return malformed(
        "no columns to draw: expected x_m and y_m, pos.x and pos.y, error_m, error_deg or "
        "speed_mps, with time_s or recordingTime");
  while (!text.empty()) {
    const string_view row = take_line(text);
    ++line;
    if (row.empty() || row.front() == '#' || row.front() == '%') continue;
    if (auto good = table.add(fields_of(row, between), line); !good) return good;
  }
  table.move_to(picture);
  return {};
}

// --- recordings of paths: the number of splines, then the numbers of each spline

struct SplineColumns {
  std::size_t count = 0;  // column of the number of splines
  std::size_t first = 0;
  std::size_t each = 0;
  std::size_t start = 0;  // offset in each spline: startPos.x y rho
  std::size_t length = 0;
};

std::optional<SplineColumns> spline_columns(std::span<const string_view> columns) {
  const auto find = [&](string_view name) {
    return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
  };
  const auto is_of = [](string_view c) { return c.starts_with("spline[0]."); };
  SplineColumns found;
  found.count = find("splineNum");
  found.each = static_cast<std::size_t>(std::ranges::count_if(columns, is_of));
  found.first = static_cast<std::size_t>(std::ranges::find_if(columns, is_of) - columns.begin());
  const std::size_t start = find("spline[0].startPos.x");
  const std::size_t length = find("spline[0].length");
  if (found.count >= columns.size() || start + 2 >= columns.size() || length + 1 >= columns.size())
    return std::nullopt;
  found.start = start - found.first;
  found.length = length - found.first;
  return found;
}

Result<void> add_last_path(string_view text, string_view name, const SplineColumns& where,
                           Picture& picture) {
  std::vector<PolarSpline> last;
  for (std::size_t line = 3; !text.empty(); ++line) {
    const auto fields = fields_of(take_line(text), ' ');
    if (fields.empty()) continue;
    const auto number = [&](std::size_t i) {
      return i < fields.size() ? number_of(fields[i]) : std::nullopt;
    };
    const auto count = number(where.count);
    if (!count || *count < 0 || *count > static_cast<double>(fields.size()) ||
        where.first + static_cast<std::size_t>(*count) * where.each > fields.size())
      return wrong(line, "the number of values does not match the number of splines");
    std::vector<PolarSpline> splines;
    for (std::size_t i = 0; i < static_cast<std::size_t>(*count); ++i) {
      const std::size_t at = where.first + i * where.each;
      const auto x = number(at + where.start);
      const auto y = number(at + where.start + 1);
      const auto rho = number(at + where.start + 2);
      const auto length = number(at + where.length);
      const auto radius = number(at + where.length + 1);
      if (!x || !y || !rho || !length || !radius)
        return wrong(line, "a spline contains text that is not a number");
      const Pose from{.x = *x, .y = *y, .rho = *rho};
      splines.push_back(*radius == 0 ? path::line(from, *length)
                                     : path::arc(from, whole_millimetres(*radius), *length));
    }
    if (!splines.empty()) last = std::move(splines);
  }
  if (last.empty()) return malformed("there is no path with splines");
  picture.trajectories.push_back(trajectory_of(last, std::string(name)));
  return {};
}

Result<void> add_recording(string_view text, string_view name, Picture& picture) {
  const string_view title = trimmed(take_line(text).substr(1), kMarks);
  string_view second = take_line(text);
  if (!second.starts_with('%')) return wrong(2, "no column names after %");
  const auto columns = fields_of(second.substr(1), ' ');
  if (const auto splines = spline_columns(columns);
      splines && std::ranges::find(columns, "pos.x") == columns.end())
    return add_last_path(text, name.empty() ? title : name, *splines, picture);
  return add_table(text, name, 2, columns, title, ' ', picture);
}

// --- other formats

Result<void> add_carmen(string_view text, string_view name, Picture& picture) {
  const auto log = localisation::read_carmen(text);
  if (!log) return log.error();
  Trajectory trajectory{name.empty() ? "odometry" : std::string(name), Role::kOdometry};
  for (const auto& scan : log->scans) {
    trajectory.times.push_back(scan.logger_time);
    trajectory.points.push_back({scan.odometry.x, scan.odometry.y});
  }
  picture.trajectories.push_back(std::move(trajectory));
  return {};
}

Result<void> add_truth(string_view text, string_view name, Picture& picture) {
  Trajectory trajectory{name.empty() ? "truth" : std::string(name), Role::kTruth};
  for (std::size_t line = 1; !text.empty(); ++line) {
    const string_view row = take_line(text);
    if (row.empty() || row.front() == '#') continue;
    const auto fields = fields_of(row, separator_of(row));
    if (fields.size() != 4 && fields.size() != 5)
      return wrong(line, std::to_string(fields.size()) + " fields: a pose has 4 or 5 numbers");
    const std::size_t at = fields.size() - 3;
    const auto time = number_of(fields[0]);
    const auto x = number_of(fields[at]);
    const auto y = number_of(fields[at + 1]);
    if (!time || !x || !y) return wrong(line, "a field is not a number");
    const Pose pose = localisation::pose_of_ros(*x, *y, 0);
    trajectory.times.push_back(*time);
    trajectory.points.push_back({pose.x, pose.y});
  }
  picture.trajectories.push_back(std::move(trajectory));
  return {};
}

bool is_carmen(string_view text) {
  for (const string_view begin : {"FLASER ", "ROBOTLASER1 ", "ODOM ", "PARAM "})
    if (text.starts_with(begin) || text.find("\n" + std::string(begin)) != string_view::npos)
      return true;
  return false;
}

}  // namespace

Trajectory trajectory_of(const std::vector<PolarSpline>& splines, std::string name) {
  constexpr double kStep = 100;  // mm
  constexpr double kStepsMax = 2000;
  Trajectory trajectory{std::move(name), Role::kPath};
  for (const PolarSpline& spline : splines) {
    const double length = spline.length;
    const double wanted = std::clamp(std::ceil(std::abs(length) / kStep), 1.0, kStepsMax);
    const int steps = spline.radius == 0 ? 1 : static_cast<int>(wanted);
    for (int k = 0; k <= steps; ++k) {
      const Pose at = path::pose_at(spline, length * k / steps);
      trajectory.points.push_back({at.x, at.y});
    }
  }
  return trajectory;
}

Result<void> add_file(string_view text, string_view name, Picture& picture) {
  if (text.starts_with('%')) return add_recording(text, name, picture);
  string_view rest = text;
  string_view first;
  std::size_t line = 0;
  while (!rest.empty() && (first.empty() || first.front() == '#')) {
    first = trimmed(take_line(rest), kMarks);
    ++line;
  }
  if (first.empty() || first.front() == '#') return malformed("the file is empty");
  const char between = separator_of(first);
  const auto fields = fields_of(first, between);
  if (std::ranges::all_of(fields, [](string_view field) { return number_of(field).has_value(); }))
    return add_truth(text, name, picture);
  if (is_carmen(text)) return add_carmen(text, name, picture);
  return add_table(rest, name, line, fields, {}, between, picture);
}

}  // namespace rack::plot
