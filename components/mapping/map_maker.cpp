#include "components/mapping/map_maker.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "components/mapping/calibration.h"
#include "components/mapping/moving.h"
#include "components/mapping/occupancy.h"
#include "components/mapping/refine.h"

namespace rack::mapping {

namespace {

constexpr double kMapMakerMargin = 500;  // mm around all points

tims::Error stopped() { return {tims::Errc::kClosed, "stopped"}; }

// Between two keyframes the poses follow the odometry, with its error distributed over the
// distance.
std::vector<Pose> poses_of_all(const Drive& drive, const Track& track) {
  std::vector<Pose> poses;
  poses.reserve(drive.scans.size());
  std::size_t key = 0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    while (key + 1 < track.keyframes.size() && track.keyframes[key + 1].scan <= i) ++key;
    const Keyframe& before = track.keyframes[key];
    const Pose ahead = track.poses[key] + (drive.scans[i].odometry - before.odometry);
    if (i < before.scan || key + 1 == track.keyframes.size()) {
      poses.push_back(ahead);
      continue;
    }
    const Keyframe& after = track.keyframes[key + 1];
    const Pose back = track.poses[key + 1] + (drive.scans[i].odometry - after.odometry);
    poses.push_back(between(
        ahead, back,
        static_cast<double>(i - before.scan) / static_cast<double>(after.scan - before.scan)));
  }
  return poses;
}

struct Box {
  MapPoint low{1e18, 1e18};
  MapPoint high{-1e18, -1e18};
  void add(double x, double y) {
    low = {std::min(low.x, x), std::min(low.y, y)};
    high = {std::max(high.x, x), std::max(high.y, y)};
  }
};

template <typename Take>
void each_beam(const Drive& drive, const DriveScan& scan, const Pose& robot, double range_max,
               const Take& take) {
  const Pose from = robot + scan.scanner;
  for (const BeamEnd& beam : drive.beams(scan)) {
    const Pose to =
        robot + Pose{.x = static_cast<double>(beam.x), .y = static_cast<double>(beam.y)};
    if (std::hypot(to.x - from.x, to.y - from.y) > range_max) continue;
    take(MapPoint{from.x, from.y}, MapPoint{to.x, to.y});
  }
}

template <typename Take>
void each_beam(const Drive& drive, const Track& track, double range_max, const Take& take) {
  for (std::size_t k = 0; k < track.keyframes.size(); ++k)
    each_beam(drive, drive.scans[track.keyframes[k].scan], track.poses[k], range_max, take);
}

double cells_of(const Box& box, double resolution) {
  const auto side = [&](double low, double high) {
    return std::max(0.0, high - low + 2 * kMapMakerMargin) / resolution;
  };
  return side(box.low.x, box.high.x) * side(box.low.y, box.high.y);
}

tims::Result<localisation::GridMap> draw(const Drive& drive, const Track& track,
                                         const MapSettings& settings) {
  Box box;
  each_beam(drive, track, settings.range_max, [&](const MapPoint& from, const MapPoint& to) {
    box.add(from.x, from.y);
    box.add(to.x, to.y);
  });
  double resolution = settings.resolution;
  // Half a percent more: the box is rounded to whole cells.
  const double too_many =
      1.005 * cells_of(box, resolution) / static_cast<double>(Occupancy::kCellsMax);
  if (too_many > 1) resolution *= std::min(2.0, std::sqrt(too_many));
  // Cells begin at multiples of their size, so that maps of different drives align.
  const auto snapped = [&](double at) {
    return std::floor((at - kMapMakerMargin) / resolution) * resolution;
  };
  auto occupancy = Occupancy::of(resolution, {snapped(box.low.x), snapped(box.low.y)},
                                 {box.high.x + kMapMakerMargin, box.high.y + kMapMakerMargin});
  if (!occupancy) return occupancy.error();
  each_beam(drive, track, settings.range_max,
            [&](const MapPoint& from, const MapPoint& to) { occupancy->add_beam(from, to); });
  return occupancy->map();
}

WithoutLoop without_loop(const Track& track, const Loops& loops) {
  std::vector<std::size_t> ends{0, track.keyframes.size() - 1};
  for (const Edge& loop : loops.edges) ends.insert(ends.end(), {loop.from, loop.to});
  std::ranges::sort(ends);
  WithoutLoop longest;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double distance =
        track.keyframes[ends[i]].travelled - track.keyframes[ends[i - 1]].travelled;
    const Pose& begin = track.poses[ends[i - 1]];
    const Pose& end = track.poses[ends[i]];
    if (distance > longest.distance) longest = {distance, {begin.x, begin.y}, {end.x, end.y}};
  }
  return longest;
}

// As far as it was driven when the edges do not determine the poses.
double uncertainty_of(std::span<const Edge> edges, const Track& track) {
  if (track.poses.size() < 2) return 0;
  const std::vector<double> deviations = spread(edges, track.poses);
  if (deviations.empty()) return track.keyframes.back().travelled;
  double sum = 0;
  for (const double mm : deviations) sum += mm;
  return sum / static_cast<double>(deviations.size());
}

tims::Error too_big(double cells, const MapSettings& settings) {
  const double most = static_cast<double>(Occupancy::kCellsMax);
  // The next 10 mm.
  const double enough = std::ceil(settings.resolution * std::sqrt(cells / most) / 10) * 10;
  return {tims::Errc::kTooBig,
          fmt::format("the map would have about {:.0f} million cells of {:.0f} mm, at most {:.0f} "
                      "million are possible: use cells of {:.0f} mm, or shorter beams",
                      cells / 1e6, settings.resolution, most / 1e6, enough)};
}

}  // namespace

double expected_cells(const Drive& drive, const MapSettings& settings) {
  Box box;
  for (const DriveScan& scan : drive.scans) {
    if (!std::isfinite(scan.odometry.x) || !std::isfinite(scan.odometry.y)) continue;
    each_beam(drive, scan, scan.odometry, settings.range_max,
              [&](const MapPoint& /*from*/, const MapPoint& to) { box.add(to.x, to.y); });
  }
  return cells_of(box, settings.resolution);
}

tims::Result<MadeMap> make_map(const Drive& recorded, const MapSettings& settings,
                               const Progress& progress) {
  const double expected = expected_cells(recorded, settings);
  if (expected > 2 * static_cast<double>(Occupancy::kCellsMax)) return too_big(expected, settings);
  const auto first = follow(recorded, progress);
  if (!first) return stopped();
  const Drive drive = corrected(recorded, calibrate(*first));
  auto track = follow(drive, progress);
  if (!track) return stopped();
  (void)forget_moving(*track);
  track = follow_again(std::move(*track), progress);
  if (!track) return stopped();
  if (track->keyframes.empty())
    return tims::Error(tims::Errc::kMalformed,
                       "no scan has enough points to make a map of: does the scanner see walls?");
  const auto loops = close_loops(*track, progress);
  if (!loops) return stopped();
  const auto edges = refine(*track, *loops, settings.rounds, progress);
  if (!edges) return stopped();
  auto doubts = find_doubts(*track, progress);
  if (!doubts) return stopped();
  auto map = draw(drive, *track, settings);
  if (!map) return map.error();
  return MadeMap{.map = std::move(map).value(),
                 .poses = poses_of_all(drive, *track),
                 .keyframes = track->keyframes.size(),
                 .searched = track->searched,
                 .unmatched = track->unmatched,
                 .loops = loops->edges.size(),
                 .removed = loops->removed,
                 .edges = edges->size(),
                 .distance = track->keyframes.back().travelled,
                 .doubts = std::move(*doubts),
                 .without_loop = without_loop(*track, *loops),
                 .uncertain = uncertainty_of(*edges, *track)};
}

}  // namespace rack::mapping
