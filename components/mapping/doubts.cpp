#include "components/mapping/doubts.h"

#include <cmath>

namespace rack::mapping {

namespace {

constexpr double kDoubtsEvery = 500;         // mm of travel between scans that are compared
constexpr double kDoubtsGap = 6000;          // mm of travel to another pass
constexpr double kDoubtsSeen = 6000;         // mm between scans with a common view
constexpr std::size_t kDoubtsScansMax = 30;  // of other passes
constexpr std::size_t kDoubtsPointsLeast = 60;
constexpr double kDoubtsShareMost = 0.25;

class Search {
 public:
  explicit Search(const Track& track) : track_(track) {
    for (std::size_t i = 0; i < track.keyframes.size(); ++i)
      if (scans_.empty() || travelled(i) - travelled(scans_.back()) >= kDoubtsEvery)
        scans_.push_back(i);
  }
  [[nodiscard]] std::size_t scans() const { return scans_.size(); }

  void look(std::size_t at) {
    const std::size_t i = scans_[at];
    Agreement all;
    std::vector<MapPoint> walls;
    const auto others = passes(i);
    for (const std::size_t j : others) {
      compare(i, j, all, walls);
      compare(j, i, all, walls);
    }
    if (all.seen + all.seen_through < kDoubtsPointsLeast) return;
    const double length = at == 0 ? 0 : travelled(i) - travelled(scans_[at - 1]);
    doubts_.compared += length;
    if (all.contradiction() <= kDoubtsShareMost) return;
    doubts_.distance += length;
    doubts_.places.push_back({track_.poses[i].x, track_.poses[i].y});
    doubts_.walls.insert(doubts_.walls.end(), walls.begin(), walls.end());
  }
  Doubts take_doubts() { return std::move(doubts_); }

 private:
  [[nodiscard]] double travelled(std::size_t i) const { return track_.keyframes[i].travelled; }

  // Scans of other passes, evenly chosen if there are many.
  [[nodiscard]] std::vector<std::size_t> passes(std::size_t i) const {
    std::vector<std::size_t> near;
    for (const std::size_t j : scans_) {
      const Pose step = track_.poses[j] - track_.poses[i];
      if (std::hypot(step.x, step.y) <= kDoubtsSeen &&
          std::abs(travelled(i) - travelled(j)) >= kDoubtsGap)
        near.push_back(j);
    }
    if (near.size() <= kDoubtsScansMax) return near;
    std::vector<std::size_t> some;
    for (std::size_t k = 0; k < kDoubtsScansMax; ++k)
      some.push_back(near[k * near.size() / kDoubtsScansMax]);
    return some;
  }

  // Walls of `i` in the view of `j`.
  void compare(std::size_t i, std::size_t j, Agreement& all, std::vector<MapPoint>& walls) const {
    const Pose step = track_.poses[i] - track_.poses[j];
    for (const ScanPoint2d& p : track_.keyframes[i].points) {
      if (!p.on_wall()) continue;
      const Pose point{.x = static_cast<double>(p.x), .y = static_cast<double>(p.y)};
      const Pose there = step + point;
      const Seen seen = track_.keyframes[j].view.judge(there.x, there.y);
      if (seen == Seen::kThere) ++all.seen;
      if (seen != Seen::kThrough) continue;
      ++all.seen_through;
      const Pose wall = track_.poses[i] + point;
      walls.push_back({wall.x, wall.y});
    }
  }

  const Track& track_;
  std::vector<std::size_t> scans_;
  Doubts doubts_;
};

}  // namespace

std::optional<Doubts> find_doubts(const Track& track, const Progress& progress) {
  Search search(track);
  for (std::size_t at = 0; at < search.scans(); ++at) {
    if (at % 64 == 0 && !progress("checking the map", at, search.scans())) return std::nullopt;
    search.look(at);
  }
  return search.take_doubts();
}

}  // namespace rack::mapping
