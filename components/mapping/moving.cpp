#include "components/mapping/moving.h"

#include <cmath>

namespace rack::mapping {

namespace {

constexpr double kMovingStretch = 3000;  // mm of travel to both sides
constexpr double kMovingEvery = 500;     // mm of travel between scans that judge
constexpr std::size_t kThroughLeast = 2;

// Scans before and after `at`.
std::vector<std::size_t> judges_of(const Track& track, std::size_t at) {
  std::vector<std::size_t> judges;
  const auto& keyframes = track.keyframes;
  const auto travelled = [&](std::size_t i) { return keyframes[i].travelled; };
  double last = travelled(at);
  for (std::size_t i = at; i-- > 0 && travelled(at) - travelled(i) <= kMovingStretch;)
    if (last - travelled(i) >= kMovingEvery) {
      judges.push_back(i);
      last = travelled(i);
    }
  last = travelled(at);
  for (std::size_t i = at + 1;
       i < keyframes.size() && travelled(i) - travelled(at) <= kMovingStretch; ++i)
    if (travelled(i) - last >= kMovingEvery) {
      judges.push_back(i);
      last = travelled(i);
    }
  return judges;
}

}  // namespace

std::size_t forget_moving(Track& track) {
  std::size_t moved = 0;
  for (std::size_t at = 0; at < track.keyframes.size(); ++at) {
    const auto judges = judges_of(track, at);
    for (ScanPoint2d& p : track.keyframes[at].points) {
      if (!p.on_wall()) continue;
      const Pose point =
          track.poses[at] + Pose{.x = static_cast<double>(p.x), .y = static_cast<double>(p.y)};
      std::size_t there = 0;
      std::size_t through = 0;
      for (const std::size_t j : judges) {
        const Pose seen_from = point - track.poses[j];
        const Seen seen = track.keyframes[j].view.judge(seen_from.x, seen_from.y);
        if (seen == Seen::kThere) ++there;
        if (seen == Seen::kThrough) ++through;
      }
      if (through < kThroughLeast || through <= there) continue;
      p.nx = p.ny = 0;
      ++moved;
    }
  }
  return moved;
}

}  // namespace rack::mapping
