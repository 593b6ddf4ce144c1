#include "components/mapping/refine.h"

#include <algorithm>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr double kRefineStretch = 1250;  // mm of travel to both sides, of scans that are combined
constexpr double kRefineGap = 6000;      // mm of travel between passes
constexpr double kRefineSeen = 4000;     // mm between places with a common view
constexpr std::size_t kPassesMax = 5;
constexpr std::size_t kStretchScansMax = 30;
constexpr double kRefineShareLeast = 0.5;
constexpr double kRefineMisfitMost = 50;  // mm
// A scan in a bare corridor slides along it, drawn by single points; such edges made maps of long
// corridors worse.
constexpr double kRefinePointsLeast = 5;
constexpr double kMovedMost = 400;  // mm: larger corrections belong to another wall
constexpr double kTurnedMost = radians(4);
// Neighbouring scans see the same walls of a pass, so their errors are correlated.
constexpr double kPassCounts = 0.1;

class Refinement {
 public:
  Refinement(const Track& track) : track_(track) {}

  void lay(std::size_t at) {
    for (const std::size_t place : passes(at)) lay_on(at, place, begin_of(place), end_of(place));
  }
  std::vector<Edge> take_edges() { return std::move(edges_); }

 private:
  [[nodiscard]] double travelled(std::size_t at) const { return track_.keyframes[at].travelled; }
  [[nodiscard]] std::size_t begin_of(std::size_t at) const {
    std::size_t first = at;
    while (first > 0 && travelled(at) - travelled(first - 1) <= kRefineStretch &&
           at - first < kStretchScansMax)
      --first;
    return first;
  }
  [[nodiscard]] std::size_t end_of(std::size_t at) const {
    std::size_t last = at;
    while (last + 1 < track_.poses.size() &&
           travelled(last + 1) - travelled(at) <= kRefineStretch && last - at < kStretchScansMax)
      ++last;
    return last;
  }

  // The nearest keyframe of each other pass, nearest first.
  [[nodiscard]] std::vector<std::size_t> passes(std::size_t at) const {
    std::vector<std::pair<double, std::size_t>> all;
    bool inside = false;
    for (std::size_t i = 0; i < track_.poses.size(); ++i) {
      const double off = std::hypot(track_.poses[i].x - track_.poses[at].x,
                                    track_.poses[i].y - track_.poses[at].y);
      if (off > kRefineSeen || std::abs(travelled(i) - travelled(at)) < kRefineGap) {
        inside = false;
        continue;
      }
      if (!inside) all.emplace_back(off, i);
      if (off < all.back().first) all.back() = {off, i};
      inside = true;
    }
    std::ranges::sort(all);
    std::vector<std::size_t> nearest;
    for (std::size_t i = 0; i < std::min(kPassesMax, all.size()); ++i)
      nearest.push_back(all[i].second);
    return nearest;
  }

  void lay_on(std::size_t at, std::size_t place, std::size_t first, std::size_t last) {
    const auto points = points_around(track_, first, last, track_.poses[place]);
    const Pose now = track_.poses[at] - track_.poses[place];
    const auto found = match(PointIndex(points), track_.keyframes[at].points, now, {},
                             {.least_information = kRefinePointsLeast});
    if (!found || found->share < kRefineShareLeast || found->misfit > kRefineMisfitMost) return;
    const Pose moved = found->pose - now;
    if (std::hypot(moved.x, moved.y) > kMovedMost ||
        std::abs(signed_angle(moved.rho)) > kTurnedMost)
      return;
    edges_.push_back({place, at, found->pose, kPassCounts * found->information});
  }

  const Track& track_;
  std::vector<Edge> edges_;
};

}  // namespace

std::optional<std::vector<Edge>> refine(Track& track, const Loops& loops, int rounds,
                                        const Progress& progress) {
  std::vector<Edge> edges = all_edges(track, loops);
  const std::size_t all = track.poses.size() * static_cast<std::size_t>(std::max(rounds, 0));
  for (int round = 0; round < rounds; ++round) {
    Refinement refinement(track);
    for (std::size_t i = 0; i < track.poses.size(); ++i) {
      const std::size_t done = static_cast<std::size_t>(round) * track.poses.size() + i;
      if (i % 32 == 0 && !progress("matching all scans against all", done, all))
        return std::nullopt;
      refinement.lay(i);
    }
    std::vector<Edge> better = refinement.take_edges();
    // The edges of odometry and first matches connect poses without other edges, and loops those
    // that passes do not.
    better.insert(better.end(), track.edges.begin(), track.edges.end());
    for (const Edge& loop : loops.edges)
      better.push_back({loop.from, loop.to, loop.step, kPassCounts * loop.information});
    if (!optimise(better, track.poses, Doubt::kAlways)) break;
    edges = std::move(better);
  }
  return edges;
}

}  // namespace rack::mapping
