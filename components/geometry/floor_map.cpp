#include "components/geometry/floor_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/text.h"
#include "components/geometry/pose.h"

namespace rack {

namespace {

constexpr double kFarthest = 1e9;  // limit of a plausible coordinate

template <typename T>
std::optional<T> number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return tims::base::parse_number<T>(text);
}

struct Group {
  int code = 0;
  std::string_view value{};
  std::size_t line = 0;  // line number of the code
};

class Groups {
 public:
  explicit Groups(std::string_view text) : left_(text) {}

  // Nothing: end of the file.
  tims::Result<std::optional<Group>> next() {
    if (left_.find_first_not_of(" \t\r\n") == std::string_view::npos) return {std::nullopt};
    const std::string_view code = take_line();
    Group group{.line = line_};
    const auto parsed = number<int>(code);
    if (!parsed) return tims::Error(tims::Errc::kMalformed, at(line_) + "no group code");
    group.code = *parsed;
    if (left_.empty())
      return tims::Error(tims::Errc::kMalformed, at(line_) + "a group code without value");
    group.value = take_line();
    return {group};
  }
  static std::string at(std::size_t line) { return "line " + std::to_string(line) + ": "; }

 private:
  std::string_view take_line() {
    const auto end = left_.find('\n');
    const std::string_view line = left_.substr(0, end);
    left_.remove_prefix(end == std::string_view::npos ? left_.size() : end + 1);
    ++line_;
    return tims::base::trimmed(line);
  }

  std::string_view left_;
  std::size_t line_ = 0;
};

// The entity that is being read.
struct Entity {
  std::string_view type{};
  std::size_t line = 0;
  std::optional<double> x{}, y{}, x2{}, y2{};
  std::int32_t layer = 0;
  std::int32_t flags = 0;
  std::optional<std::int32_t> count{};
  std::vector<DxfPoint> vertices{};  // LWPOLYLINE
  bool bad = false;                  // a value is not a number
};

constexpr std::int32_t kClosed = 1;
constexpr std::int32_t kMesh = 16 | 64;  // flags of POLYLINE: its vertices do not form a line

class Reader {
 public:
  // False: the end of the section or file.
  bool take(const Group& group) {
    if (group.code == 0) {
      finish();
      entity_ = {.type = group.value, .line = group.line};
      return group.value != "EOF";
    }
    if (entity_.type == "SECTION" && group.code == 2) section_ = group.value;
    value(group);
    return true;
  }

  DxfDrawing end() {
    finish();
    finish_polyline();
    return std::move(drawing_);
  }

 private:
  void value(const Group& group) {
    switch (group.code) {
      case 8:
        entity_.layer = number<std::int32_t>(group.value).value_or(0);
        break;
      case 10:
        coordinate(group, entity_.x);
        if (is_light()) entity_.vertices.push_back({entity_.x.value_or(0), 0});
        break;
      case 20:
        coordinate(group, entity_.y);
        if (is_light() && !entity_.vertices.empty())
          entity_.vertices.back().y = entity_.y.value_or(0);
        break;
      case 11:
        return coordinate(group, entity_.x2);
      case 21:
        return coordinate(group, entity_.y2);
      case 70:
        entity_.flags = number<std::int32_t>(group.value).value_or(0);
        break;
      case 90:
        entity_.count = number<std::int32_t>(group.value);
        break;
      default:
        break;
    }
  }

  void coordinate(const Group& group, std::optional<double>& to) {
    to = number<double>(group.value);
    if (!to || !(std::abs(*to) <= kFarthest)) entity_.bad = true;
  }

  [[nodiscard]] bool is_light() const { return entity_.type == "LWPOLYLINE"; }

  void finish() {
    const std::string_view type = entity_.type;
    if (type == "ENDSEC" || type == "EOF") {
      finish_polyline();
      section_ = {};
    } else if (type.empty() || type == "SECTION" || (section_ != "ENTITIES" && !section_.empty())) {
      return;
    } else if (type == "VERTEX") {
      vertex();
    } else if (type == "SEQEND") {
      sequence_ended_ = true;
      finish_polyline();
    } else {
      finish_polyline();
      finish_entity();
    }
  }

  void finish_entity() {
    const std::string_view type = entity_.type;
    if (type == "LINE") return line();
    if (type == "POINT") return point();
    if (type == "LWPOLYLINE") return light_polyline();
    if (type == "POLYLINE") {
      polyline_ = std::move(entity_);
      polyline_->vertices.clear();
      sequence_ended_ = false;
      return;
    }
    ++drawing_.others;
  }

  void line() {
    if (entity_.bad) return skip(entity_, "a coordinate is not a number");
    if (!entity_.x || !entity_.y || !entity_.x2 || !entity_.y2)
      return skip(entity_, "without an end");
    add({*entity_.x, *entity_.y}, {*entity_.x2, *entity_.y2}, entity_);
  }

  void point() {
    if (entity_.bad) return skip(entity_, "a coordinate is not a number");
    if (!entity_.x || !entity_.y) return skip(entity_, "without coordinates");
    add({*entity_.x, *entity_.y}, {*entity_.x, *entity_.y}, entity_);
  }

  void light_polyline() {
    const Entity polyline = std::move(entity_);
    if (polyline.bad) return skip(polyline, "a coordinate is not a number");
    if (polyline.count && std::cmp_not_equal(*polyline.count, polyline.vertices.size()))
      return skip(polyline, "has a wrong number of vertices");
    add_all(polyline);
  }

  void vertex() {
    if (!polyline_) return skip(entity_, "without POLYLINE");
    if (entity_.bad || !entity_.x || !entity_.y) {
      polyline_->bad = true;
    } else {
      polyline_->vertices.push_back({*entity_.x, *entity_.y});
    }
  }

  void finish_polyline() {
    if (!polyline_) return;
    const Entity polyline = std::move(*polyline_);
    polyline_.reset();
    if (polyline.bad) return skip(polyline, "a coordinate is not a number");
    if (!sequence_ended_) skip(polyline, "without SEQEND");
    if ((polyline.flags & kMesh) != 0) return skip(polyline, "is a mesh");
    add_all(polyline);
  }

  void add_all(const Entity& polyline) {
    const auto& points = polyline.vertices;
    for (std::size_t i = 1; i < points.size(); ++i) add(points[i - 1], points[i], polyline);
    if ((polyline.flags & kClosed) != 0 && points.size() > 2)
      add(points.back(), points.front(), polyline);
  }

  void add(const DxfPoint& from, const DxfPoint& to, const Entity& entity) {
    if (drawing_.lines.size() == DxfDrawing::kLinesMax)
      return skip(entity, "and what follows: too many lines");
    drawing_.lines.push_back({from, to, entity.layer});
  }

  void skip(const Entity& entity, std::string_view why) {
    if (drawing_.skipped.size() == DxfDrawing::kSkippedMax) return;
    // The name of a type may be of any length.
    drawing_.skipped.push_back(Groups::at(entity.line) + std::string(entity.type.substr(0, 20)) +
                               " " + std::string(why));
  }

  DxfDrawing drawing_;
  std::string_view section_{};
  Entity entity_{};
  std::optional<Entity> polyline_;
  bool sequence_ended_ = false;
};

}  // namespace

tims::Result<DxfDrawing> read_dxf(std::string_view text) {
  if (text.starts_with("AutoCAD Binary DXF"))
    return tims::Error(tims::Errc::kMalformed, "binary DXF: save it as text");
  Groups groups(text);
  Reader reader;
  for (;;) {
    const auto group = groups.next();
    if (!group) return group.error();
    if (!*group || !reader.take(**group)) break;
  }
  return reader.end();
}

namespace {

constexpr double kCorner = 1e-3;  // mm: no ray passes between joined walls
constexpr double kNearlyStraight = 1e-6;

}  // namespace

FloorMap::FloorMap(const DxfDrawing& drawing, double scale, double offset_x, double offset_y) {
  const auto point = [&](const DxfPoint& p) {
    return MapPoint{(p.y - offset_x) * scale, (p.x - offset_y) * scale};
  };
  for (const DxfLine& line : drawing.lines) {
    const MapPoint from = point(line.from);
    const MapPoint to = point(line.to);
    const MapPoint extent{to.x - from.x, to.y - from.y};
    walls_.push_back({from, extent, std::hypot(extent.x, extent.y)});
  }
}

void FloorMap::cast(const RayFan& fan, double max_range, std::span<double> ranges) const {
  std::ranges::fill(ranges, max_range);
  for (const Wall& wall : walls_) {
    if (wall.length > kCorner) cast(wall, fan, ranges);
  }
}

// Only the rays between the directions of the wall's ends are tested: the cost for all rays of a
// scan is little more than that of one ray against all walls.
void FloorMap::cast(const Wall& wall, const RayFan& fan, std::span<double> ranges) {
  const double x = wall.from.x - fan.from.x;
  const double y = wall.from.y - fan.from.y;
  const double begin = std::atan2(y, x);
  const double turn = signed_angle(std::atan2(y + wall.extent.y, x + wall.extent.x) - begin);
  double first = turn < 0 ? begin + turn : begin;
  double width = std::abs(turn);
  if (width > kPi - kNearlyStraight) {  // the point is on the wall: either side may be the front
    first = begin;
    width = 2 * kPi;
  }
  const double count = static_cast<double>(ranges.size());
  double from = heading(first - fan.first) - 2 * kPi;
  while (from <= fan.step * count) {  // a fan may contain a direction more than once
    const double low = std::clamp(std::floor(from / fan.step), 0.0, count);
    const double high = std::clamp(std::ceil((from + width) / fan.step) + 1, 0.0, count);
    for (auto i = static_cast<std::size_t>(low); i < static_cast<std::size_t>(high); ++i) {
      const double angle = fan.first + fan.step * static_cast<double>(i);
      ranges[i] = range(wall, fan.from, angle, ranges[i]);
    }
    from += 2 * kPi;
  }
}

double FloorMap::range(const Wall& wall, const MapPoint& from, double angle, double otherwise) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double x = wall.from.x - from.x;
  const double y = wall.from.y - from.y;
  const double across = c * wall.extent.y - s * wall.extent.x;
  if (std::abs(across) < kNearlyStraight * wall.length) return otherwise;  // along the wall
  const double range = (x * wall.extent.y - y * wall.extent.x) / across;
  const double part = (x * s - y * c) / across;  // of the wall
  const double tolerance = kCorner / wall.length;
  const bool hits = range >= 0 && part >= -tolerance && part <= 1 + tolerance;
  return hits ? std::min(range, otherwise) : otherwise;
}

double FloorMap::clearance(const MapPoint& at) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls_) {
    const double x = at.x - wall.from.x;
    const double y = at.y - wall.from.y;
    const double square = wall.length * wall.length;
    const double part =
        square == 0 ? 0 : std::clamp((x * wall.extent.x + y * wall.extent.y) / square, 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(x - part * wall.extent.x, y - part * wall.extent.y));
  }
  return nearest;
}

}  // namespace rack
