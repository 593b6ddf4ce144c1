#include "tools/map_maker/warnings.h"

#include <algorithm>

#include <fmt/core.h>

#include "components/localisation/ros_map.h"
#include "components/mapping/occupancy.h"

namespace rack::map_maker {

namespace {

constexpr double kDoubtfulShare = 0.02;
constexpr double kDoubtfulLeast = 2000;  // mm
// The estimate is cautious: two to five times the error of made drives.
constexpr double kUncertainMost = 500;  // mm
constexpr double kUncertainByDistance = 0.001;
constexpr double kRemovedShareMost = 0.3;  // of the loops that were found
constexpr std::size_t kRemovedLeast = 10;

std::string place(const MapPoint& at) {
  const auto ros = localisation::ros_of_pose({.x = at.x, .y = at.y});
  return fmt::format("x {:.1f}, y {:.1f}", ros.x, ros.y);
}

}  // namespace

bool contradicts_itself(const mapping::MadeMap& made) {
  const mapping::Doubts& doubts = made.doubts;
  return !doubts.places.empty() &&
         doubts.distance > std::max(kDoubtfulLeast, kDoubtfulShare * doubts.compared);
}

std::vector<std::string> warnings(const mapping::MadeMap& made,
                                  const mapping::MapSettings& settings,
                                  const std::string& picture) {
  std::vector<std::string> all;
  if (made.map.resolution > settings.resolution)
    all.push_back(
        fmt::format("cells of {:.0f} mm, because the map would have more than {} million otherwise",
                    made.map.resolution, mapping::Occupancy::kCellsMax / 1'000'000));
  if (contradicts_itself(made))
    all.push_back(fmt::format(
        "along {:.1f} m of {:.1f} m driven more than once, scans see through walls of the map, "
        "first at {}: corridors are drawn twice or over each other there, or doors and furniture "
        "have moved. See {} (red: these walls)",
        made.doubts.distance / 1000, made.doubts.compared / 1000, place(made.doubts.places.front()),
        picture));
  if (made.removed >= kRemovedLeast &&
      static_cast<double>(made.removed) >
          kRemovedShareMost * static_cast<double>(made.removed + made.loops))
    all.push_back(fmt::format(
        "{} of {} places that looked like earlier ones contradicted the others: the building has "
        "parts that look alike, and some of them can be drawn at the wrong place",
        made.removed, made.removed + made.loops));
  if (made.uncertain > std::max(kUncertainMost, kUncertainByDistance * made.distance))
    all.push_back(fmt::format(
        "the measurements allow errors of about {:.1f} m on average, however straight the map "
        "looks: bare corridors do not determine distances, and {:.0f} m from {} to {} were driven "
        "without coming back to an earlier place. Return to earlier places more often, or drive "
        "the route a second time",
        made.uncertain / 1000, made.without_loop.distance / 1000, place(made.without_loop.begin),
        place(made.without_loop.end)));
  return all;
}

}  // namespace rack::map_maker
