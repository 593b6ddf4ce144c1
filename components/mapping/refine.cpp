#include "components/mapping/refine.h"

#include <algorithm>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr double kStretch = 2500;  // mm of way, of scans that are one
constexpr double kGap = 6000;      // mm of way between passes
constexpr double kSeen = 4000;     // mm: places that see the same
constexpr std::size_t kPassesMax = 5;
constexpr std::size_t kStretchScansMax = 30;
constexpr double kShareLeast = 0.5;
constexpr double kMisfitMost = 50;  // mm
constexpr double kMovedMost = 400;  // mm: a match beyond is of another wall
constexpr double kTurnedMost = radians(4);

class Refinement {
 public:
  Refinement(const Track& track) : track_(track) {}

  // The scan with the stretch that ends before it, the one that begins behind it, and all passes.
  void lay(std::size_t at) {
    const std::size_t last = track_.poses.size() - 1;
    if (at > 0) lay_on(at, at - 1, begin_of(at - 1), at - 1);
    if (at < last) lay_on(at, at + 1, at + 1, end_of(at + 1));
    for (const std::size_t place : passes(at)) {
      const std::size_t first =
          std::max(begin_of(place, kStretch / 2), place > 30 ? place - 30 : 0);
      lay_on(at, place, first, end_of(place, kStretch / 2));
    }
  }
  std::vector<Edge> take_edges() { return std::move(edges_); }

 private:
  [[nodiscard]] double way(std::size_t at) const { return track_.keyframes[at].way; }
  [[nodiscard]] std::size_t begin_of(std::size_t at, double most = kStretch) const {
    std::size_t first = at;
    while (first > 0 && way(at) - way(first - 1) <= most && at - first < kStretchScansMax) --first;
    return first;
  }
  [[nodiscard]] std::size_t end_of(std::size_t at, double most = kStretch) const {
    std::size_t last = at;
    while (last + 1 < track_.poses.size() && way(last + 1) - way(at) <= most &&
           last - at < kStretchScansMax)
      ++last;
    return last;
  }

  // The nearest keyframe of each other pass, the nearest ones first.
  [[nodiscard]] std::vector<std::size_t> passes(std::size_t at) const {
    std::vector<std::pair<double, std::size_t>> all;
    bool inside = false;
    for (std::size_t i = 0; i < track_.poses.size(); ++i) {
      const double off = std::hypot(track_.poses[i].x - track_.poses[at].x,
                                    track_.poses[i].y - track_.poses[at].y);
      if (off > kSeen || std::abs(way(i) - way(at)) < kGap) {
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
    const auto found = match(PointIndex(points), track_.keyframes[at].points, now);
    if (!found || found->share < kShareLeast || found->misfit > kMisfitMost) return;
    const Pose moved = found->pose - now;
    if (std::hypot(moved.x, moved.y) > kMovedMost ||
        std::abs(signed_angle(moved.rho)) > kTurnedMost)
      return;
    edges_.push_back({place, at, found->pose, found->information});
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
      if (i % 32 == 0 && !progress("laying all scans on all", done, all)) return std::nullopt;
      refinement.lay(i);
    }
    std::vector<Edge> better = refinement.take_edges();
    // Odometry and first matches hold together what nothing else does.
    better.insert(better.end(), track.edges.begin(), track.edges.end());
    if (!optimise(better, track.poses, Doubt::kAlways)) break;
    edges = std::move(better);
  }
  return edges;
}

}  // namespace rack::mapping
