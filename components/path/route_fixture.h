// For tests: routes from files, and random ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "components/geometry/coordinates.h"
#include "components/path/path_maker.h"
#include "components/path/rddf.h"

namespace rack::path {

inline std::string route_file(const std::string& name) {
  std::ifstream file(std::string(ROUTES) + "/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

// In a world whose origin is near the first waypoint.
inline tims::Result<std::vector<Waypoint2d>> route(const std::string& name) {
  const auto points = read_rddf(route_file(name));
  if (!points) return points.error();
  navigation::Coordinates world({.reference = navigation::PositionReference::kUtm}, true);
  return to_waypoints(*points, [&](const PositionWgs84Data& at) { return world.from(at); });
}

inline double distance_to_leg(double x, double y, const Waypoint2d& from, const Waypoint2d& to) {
  const double ax = from.x;
  const double ay = from.y;
  const double dx = to.x - ax;
  const double dy = to.y - ay;
  const double square = dx * dx + dy * dy;
  const double part =
      square > 0 ? std::clamp(((x - ax) * dx + (y - ay) * dy) / square, 0.0, 1.0) : 0;
  return std::hypot(x - ax - part * dx, y - ay - part * dy);
}

// The distance of a point outside of the corridor of the route; negative inside. Only legs whose
// number is within `neighbours` of `near` count.
inline double outside(double x, double y, const std::vector<Waypoint2d>& route,
                      const PathLimits& limits, std::size_t near = 0,
                      std::size_t neighbours = 1000000) {
  double least = 1e12;
  const std::size_t first = near > neighbours ? near - neighbours : 0;
  const std::size_t end = std::min(route.size() - 1, near + neighbours + 1);
  for (std::size_t i = first; i < end; ++i) {
    const double lbo =
        route[i + 1].lbo > 0 ? static_cast<double>(route[i + 1].lbo) : limits.corridor;
    least = std::min(least, distance_to_leg(x, y, route[i], route[i + 1]) - lbo);
  }
  return least;
}

}  // namespace rack::path
