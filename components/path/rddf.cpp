#include "components/path/rddf.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/text.h"
#include "components/geometry/pose.h"

namespace rack::path {

namespace {

constexpr std::size_t kFieldsMin = 5;
constexpr std::size_t kFieldsMax = 8;
constexpr double kFoot = 304.8;          // mm
constexpr double kMilePerHour = 447.04;  // mm/s
constexpr double kOffsetMax = 10000;     // ft
constexpr double kSpeedMax = 300;        // mph

tims::Error malformed(std::size_t line, std::string_view what) {
  return {tims::Errc::kMalformed, "line " + std::to_string(line) + ": " + std::string(what)};
}

// Removes the part up to the separator from the text and returns it.
std::string_view take_until(std::string_view& text, char separator) {
  const auto end = text.find(separator);
  const auto part = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return part;
}

// A number from `least` to `most` without any other text.
std::optional<double> number(std::string_view text, double least, double most) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  if (std::isnan(value) || value < least || value > most) return std::nullopt;
  return value;
}

tims::Result<RddfPoint> read_line(std::string_view text, std::size_t line) {
  std::array<std::string_view, kFieldsMax> fields;
  std::size_t count = 0;
  while (!text.empty() && count < fields.size())
    fields[count++] = tims::base::trimmed(take_until(text, ','));
  if (count < kFieldsMin || !text.empty())
    return malformed(line,
                     "a waypoint has 5 to 8 fields: number, latitude, longitude, lateral "
                     "boundary offset (ft), speed limit (mph)");
  const auto id = number(fields[0], 0, 1e9);
  const auto latitude = number(fields[1], -90, 90);
  const auto longitude = number(fields[2], -180, 180);
  const auto offset = number(fields[3], 0, kOffsetMax);
  const auto speed = number(fields[4], 0, kSpeedMax);
  if (!id) return malformed(line, "the first field is not the number of a waypoint");
  if (!latitude) return malformed(line, "the second field is not a latitude in degrees");
  if (!longitude) return malformed(line, "the third field is not a longitude in degrees");
  if (!offset) return malformed(line, "the fourth field is not a lateral boundary offset in feet");
  if (!speed) return malformed(line, "the fifth field is not a speed in miles per hour");
  return RddfPoint{static_cast<i32>(*id), radians(*latitude), radians(*longitude), *offset * kFoot,
                   *speed * kMilePerHour};
}

bool out_of_range(i32 mm) {
  return mm == std::numeric_limits<i32>::max() || mm == std::numeric_limits<i32>::min();
}

}  // namespace

tims::Result<std::vector<RddfPoint>> read_rddf(std::string_view text) {
  std::vector<RddfPoint> points;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto content = tims::base::trimmed(take_until(text, '\n'));
    if (content.empty() || content.front() == '#') continue;
    if (points.size() == kWaypointsMax)
      return tims::Error(tims::Errc::kTooBig, "line " + std::to_string(line) + ": more than " +
                                                  std::to_string(kWaypointsMax) + " waypoints");
    const auto point = read_line(content, line);
    if (!point) return point.error();
    points.push_back(*point);
  }
  return points;
}

tims::Result<std::vector<Waypoint2d>> to_waypoints(std::span<const RddfPoint> points,
                                                   const ToWorld& to_world) {
  std::vector<Waypoint2d> waypoints;
  waypoints.reserve(points.size());
  for (const RddfPoint& point : points) {
    // The fields of the leg that ends here.
    const RddfPoint& leg = waypoints.empty() ? point : points[waypoints.size() - 1];
    const auto name = [&] { return "waypoint " + std::to_string(point.number) + ": "; };
    const auto at = to_world({.latitude = point.latitude, .longitude = point.longitude});
    if (!at) return tims::Error(at.error().code(), name() + at.error().detail());
    if (out_of_range(at->pos.x) || out_of_range(at->pos.y))
      return tims::Error(tims::Errc::kInvalidArgument,
                         name() +
                             "it is more than 2000 km from the origin of the world: set "
                             "an offset of Position near the route, or autoOffset=1");
    if (leg.speed == 0 && points.size() > 1)
      return tims::Error(
          tims::Errc::kInvalidArgument,
          name() + "the leg to it has speed limit 0; only the last line may have it");
    Waypoint2d waypoint;
    waypoint.x = at->pos.x;
    waypoint.y = at->pos.y;
    waypoint.speed = static_cast<i32>(leg.speed);
    waypoint.lbo = static_cast<i32>(leg.offset);
    waypoint.id = point.number;
    waypoints.push_back(waypoint);
  }
  return waypoints;
}

}  // namespace rack::path
