// Any text is refused with a line number, or yields waypoints; any waypoints are refused with a
// reason, or yield a path that is within its limits, is continuous, and ends at rest.
#include <cmath>

#include "components/geometry/coordinates.h"
#include "components/path/path_maker.h"
#include "components/path/rddf.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace rack;
using tims::fuzz::require;

void check_path(std::span<const Waypoint2d> waypoints, const path::PathLimits& limits) {
  const auto made = path::make_path(waypoints, limits);
  if (!made) {
    require(!made.error().detail().empty());
    return;
  }
  require(!made->empty() && made->size() <= path::kSplinesMax);
  for (std::size_t i = 0; i < made->size(); ++i) {
    const PolarSpline& spline = (*made)[i];
    require(spline.length != 0);
    require(spline.radius == 0 || std::abs(1.0 * spline.radius) >= limits.radius_min);
    require(spline.vMax >= 1 && spline.vMax <= std::max(1.0, limits.speed_max));
    require(spline.vStart >= 0 && spline.vStart <= spline.vMax);
    require(spline.vEnd >= 0 && spline.vEnd <= spline.vMax);
    if (i > 0) require((*made)[i - 1].vEnd == spline.vStart);
  }
  require(made->front().vStart == 0 && made->back().vEnd == 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const path::PathLimits limits{.radius_min = input.number<std::uint8_t>() * 20.0,
                                .half_width = input.number<std::uint8_t>() * 2.0};
  const auto points = path::read_rddf(input.text());
  if (!points) {
    require(!points.error().detail().empty());
    return 0;
  }
  for (const path::RddfPoint& point : *points)
    require(std::isfinite(point.latitude) && std::isfinite(point.longitude));
  navigation::Coordinates world({.reference = navigation::PositionReference::kUtm}, true);
  const auto waypoints =
      path::to_waypoints(*points, [&](const PositionWgs84Data& at) { return world.from(at); });
  if (waypoints)
    check_path(*waypoints, limits);
  else
    require(!waypoints.error().detail().empty());
  return 0;
}
