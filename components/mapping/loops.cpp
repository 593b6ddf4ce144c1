#include "components/mapping/loops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "components/mapping/scan_search.h"

namespace rack::mapping {

namespace {

constexpr double kEvery = 1000;      // mm of travel between searches
constexpr double kLoopsGap = 10000;  // mm of travel: less is not a loop
constexpr double kLoopsStretch =
    2000;  // mm of travel to both sides, of the stretch that is matched
constexpr double kPlace =
    6000;  // mm of travel to both sides, of the stretch that it is matched against
constexpr double kLoopsSeen = 3000;    // mm between two places with a common view
constexpr std::size_t kPlacesMax = 4;  // candidates of one search
constexpr double kGrain = 120;         // mm between points used in the search
// The possible error of a pose after a distance without a loop.
constexpr double kWindowLeast = 300;  // mm
constexpr double kWindowMost = 8000;
constexpr double kWindowByDistance = 0.05;
constexpr double kTurnLeast = radians(4);
constexpr double kTurnMost = radians(35);
constexpr double kTurnByDistance = radians(0.25) / 1000;
constexpr double kLoopsScoreLeast = 0.45;
constexpr double kLoopsShareLeast = 0.7;
constexpr double kLoopsMisfitMost = 50;  // mm
// Conditions for a second match that confirms a loop.
constexpr double kSecondDistanceLeast = 500;  // mm
constexpr double kSecondDistanceMost = 6000;
constexpr double kSecondPlaceMost = 12000;
constexpr double kSameDistance = 300;  // mm
constexpr double kSameTurn = radians(3);
constexpr double kFarOff = 500;  // mm: a loop with a larger correction is closed immediately
constexpr std::size_t kAtOnce = 10;

double length_of(const Pose& step) { return std::hypot(step.x, step.y); }

// Thins points to a distance of about kGrain.
std::vector<ScanPoint2d> thinned(std::span<const ScanPoint2d> points) {
  std::vector<std::pair<std::int64_t, std::size_t>> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row =
        static_cast<std::int64_t>(std::floor(static_cast<double>(points[i].x) / kGrain));
    const auto column =
        static_cast<std::int64_t>(std::floor(static_cast<double>(points[i].y) / kGrain));
    cells.emplace_back(row * 1'000'003 + column, i);
  }
  std::ranges::sort(cells);
  std::vector<ScanPoint2d> few;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (i == 0 || cells[i].first != cells[i - 1].first) few.push_back(points[cells[i].second]);
  return few;
}

class LoopCloser {
 public:
  explicit LoopCloser(Track& track) : track_(track) {}

  // Matches the keyframe's stretch against all places that it may be near.
  void look(std::size_t at) {
    const Stretch stretch = around(at, kLoopsStretch);
    std::vector<ScanPoint2d> points;
    std::vector<ScanPoint2d> few;
    for (const std::size_t place : places(at)) {
      if (points.empty()) {
        points = points_around(track_, stretch.first, stretch.last, track_.poses[at]);
        few = thinned(points);
      }
      ++loops_.tried;
      if (const auto found = search(at, place, points, few)) consider(*found);
    }
    const bool much = unused_ > 0 && most_off_ > kFarOff;
    if (much || unused_ >= kAtOnce) close();
  }
  void close() {
    if (unused_ == 0) return;
    (void)optimise(all_edges(track_, loops_), track_.poses, Doubt::kNotAtFirst);
    unused_ = 0;
    most_off_ = 0;
  }
  Loops take_loops() { return std::move(loops_); }

 private:
  struct Stretch {
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] double travelled(std::size_t at) const { return track_.keyframes[at].travelled; }

  [[nodiscard]] Stretch around(std::size_t at, double reach) const {
    Stretch stretch{at, at};
    while (stretch.first > 0 && travelled(at) - travelled(stretch.first - 1) <= reach &&
           at - stretch.first < 60)
      --stretch.first;
    while (stretch.last + 1 < track_.poses.size() &&
           travelled(stretch.last + 1) - travelled(at) <= reach && stretch.last - at < 60)
      ++stretch.last;
    return stretch;
  }

  // The possible error between two keyframes: by the distance between them, or since the last loop.
  [[nodiscard]] Window window(std::size_t at, std::size_t place) const {
    const double alone = std::min(travelled(at) - closed_at_, travelled(at) - travelled(place));
    return {.distance = std::min(kWindowLeast + kWindowByDistance * alone, kWindowMost),
            .turn = std::min(kTurnLeast + kTurnByDistance * alone, kTurnMost)};
  }

  // The nearest keyframe of each pass, and the nearest of those.
  [[nodiscard]] std::vector<std::size_t> places(std::size_t at) const {
    std::vector<std::pair<double, std::size_t>> passes;
    bool inside = false;
    for (std::size_t i = 0; i < at && travelled(at) - travelled(i) > kLoopsGap; ++i) {
      const double off = length_of(track_.poses[i] - track_.poses[at]);
      if (off > window(at, i).distance + kLoopsSeen) {
        inside = false;
        continue;
      }
      const bool is_new = !inside || travelled(i) - travelled(passes.back().second) > 2 * kPlace;
      if (is_new) passes.emplace_back(off, i);
      if (!is_new && off < passes.back().first) passes.back() = {off, i};
      inside = true;
    }
    std::ranges::sort(passes);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < std::min(kPlacesMax, passes.size()); ++i)
      found.push_back(passes[i].second);
    return found;
  }

  std::optional<Edge> search(std::size_t at, std::size_t place, std::span<const ScanPoint2d> points,
                             std::span<const ScanPoint2d> few) const {
    Stretch stretch = around(place, kPlace);
    while (stretch.last > place && travelled(at) - travelled(stretch.last) < kLoopsGap / 2)
      --stretch.last;
    const auto there = points_around(track_, stretch.first, stretch.last, track_.poses[place]);
    const auto found = ScanSearch(there).find(few, track_.poses[at] - track_.poses[place],
                                              window(at, place), kLoopsScoreLeast);
    if (!found) return std::nullopt;
    const auto matched = match(PointIndex(there), points, found->pose);
    if (!matched || matched->share < kLoopsShareLeast || matched->misfit > kLoopsMisfitMost)
      return std::nullopt;
    return Edge{place, at, matched->pose, matched->information};
  }

  void consider(const Edge& edge) {
    ++loops_.found;
    bool believed = false;
    for (auto& [other, used] : found_) {
      if (!agree(edge, other)) continue;
      believed = true;
      if (!used) use(other);
      used = true;
    }
    if (believed) use(edge);
    found_.emplace_back(edge, believed);
  }

  void use(const Edge& edge) {
    const Pose is = track_.poses[edge.to] - track_.poses[edge.from];
    most_off_ = std::max(most_off_, length_of(is - edge.step));
    loops_.edges.push_back(edge);
    closed_at_ = std::max(closed_at_, travelled(edge.to));
    ++unused_;
  }

  [[nodiscard]] bool agree(const Edge& a, const Edge& b) const {
    const double apart = std::abs(travelled(a.to) - travelled(b.to));
    if (apart < kSecondDistanceLeast || apart > kSecondDistanceMost) return false;
    if (std::abs(travelled(a.from) - travelled(b.from)) > kSecondPlaceMost) return false;
    const auto& poses = track_.poses;
    const Pose by_b = (poses[b.from] - poses[a.from]) + b.step + (poses[a.to] - poses[b.to]);
    const Pose off = by_b - a.step;
    return length_of(off) <= kSameDistance && std::abs(signed_angle(off.rho)) <= kSameTurn;
  }

  Track& track_;
  Loops loops_;
  std::vector<std::pair<Edge, bool>> found_;
  double closed_at_ = 0;  // mm of travel
  double most_off_ = 0;
  std::size_t unused_ = 0;  // edges since the last optimisation
};

}  // namespace

std::vector<Edge> all_edges(const Track& track, const Loops& loops) {
  std::vector<Edge> edges = track.edges;
  edges.insert(edges.end(), loops.edges.begin(), loops.edges.end());
  return edges;
}

std::optional<Loops> close_loops(Track& track, const Progress& progress) {
  LoopCloser closer(track);
  double looked_at = 0;
  for (std::size_t i = 0; i < track.keyframes.size(); ++i) {
    if (track.keyframes[i].travelled - looked_at < kEvery) continue;
    looked_at = track.keyframes[i].travelled;
    if (!progress("closing loops", i, track.keyframes.size())) return std::nullopt;
    closer.look(i);
  }
  closer.close();
  return closer.take_loops();
}

}  // namespace rack::mapping
