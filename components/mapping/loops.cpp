#include "components/mapping/loops.h"

#include <algorithm>
#include <cmath>

#include "components/mapping/scan_search.h"
#include "components/mapping/uncertainty.h"

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
constexpr double kNearView = 16000;    // mm around a place, of points used in the search
constexpr double kLoopsScoreLeast = 0.35;
constexpr double kMatchShareLeast = 0.3;    // of all points
constexpr double kLoopsShareLeast = 0.7;    // of those that the other stretch can see
constexpr double kLoopsCoveredLeast = 0.4;  // share of points that it can see
constexpr double kWeakLeast = 0.1;  // share of points below which a direction is not determined
constexpr double kWeakMargin = 0.1;
constexpr float kOnWall = 100;           // mm
constexpr double kLoopsMisfitMost = 50;  // mm
constexpr double kContradictionMost = 0.15;
// Conditions for a second match that confirms a loop.
constexpr double kSecondDistanceLeast = 500;  // mm
constexpr double kSecondDistanceMost = 6000;
constexpr double kSecondPlaceMost = 12000;
constexpr double kSameDistance = 300;  // mm
constexpr double kSameTurn = radians(3);
constexpr double kFarOff = 500;  // mm: a loop with a larger correction is closed immediately
constexpr std::size_t kAtOnce = 10;

// Searches in windows larger than this.
constexpr double kWide = 3000;  // mm
constexpr double kWideStretch = 10000;
constexpr double kWidePlace = 14000;
constexpr double kWideView = 15000;  // mm around a stretch: farther points are left out
constexpr double kWideGrain = 200;
constexpr double kWideCell = 100;
constexpr std::size_t kWideLevels = 8;
constexpr std::size_t kWidePlacesMax = 24;
constexpr double kWideScoreLeast = 0.4;
constexpr double kWideShareLeast = 0.75;
constexpr double kWideEvery = 0.15;  // of the window, mm of travel between searches
constexpr double kWideEveryMost = 4000;
constexpr double kAlike = 0.93;            // of the best score: fits about as well
constexpr double kOtherPlace = 1500;       // mm from the best
constexpr double kAcrossLeast = 0.12;      // share of the walls that determine the weaker direction
constexpr double kWideSecondMost = 30000;  // mm of travel
constexpr double kWideSameDistance = 500;  // mm
constexpr double kWideSameByDistance = 0.03;
constexpr double kWideSameTurn = radians(5);
constexpr std::size_t kWideAgreeLeast = 2;

// Of loops whose poses were optimised.
constexpr double kClosedOff = 400;  // mm
constexpr double kClosedTurn = radians(4);
constexpr double kClosedContradictionMost = 0.3;
constexpr double kLinkedWay = 4000;  // mm: nearer places are linked already
constexpr int kPassesMost = 2;
constexpr double kViewEvery = 800;  // mm of travel between scans that are compared

double length_of(const Pose& step) { return std::hypot(step.x, step.y); }

// Thins points to a distance of about `grain`.
std::vector<ScanPoint2d> thinned(std::span<const ScanPoint2d> points, double grain) {
  std::vector<std::pair<std::int64_t, std::size_t>> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row =
        static_cast<std::int64_t>(std::floor(static_cast<double>(points[i].x) / grain));
    const auto column =
        static_cast<std::int64_t>(std::floor(static_cast<double>(points[i].y) / grain));
    cells.emplace_back(row * 1'000'003 + column, i);
  }
  std::ranges::sort(cells);
  std::vector<ScanPoint2d> few;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (i == 0 || cells[i].first != cells[i - 1].first) few.push_back(points[cells[i].second]);
  return few;
}

// The direction in which the walls determine the position worst: along a corridor.
struct Weakest {
  double x = 0;
  double y = 0;
  double share = 0;  // of the walls that determine it: 0 without doors, 0.5 in a room
  [[nodiscard]] bool is_determined_by(const ScanPoint2d& p) const {
    return std::abs(x * static_cast<double>(p.nx) + y * static_cast<double>(p.ny)) > 0.7;
  }
};

Weakest weakest_of(std::span<const ScanPoint2d> points) {
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const ScanPoint2d& p : points) {
    const auto nx = static_cast<double>(p.nx);
    const auto ny = static_cast<double>(p.ny);
    xx += nx * nx;
    xy += nx * ny;
    yy += ny * ny;
  }
  const double all = xx + yy;
  if (all <= 0) return {};
  const double strongest = std::atan2(2 * xy, xx - yy) / 2;
  return {-std::sin(strongest), std::cos(strongest), 0.5 - std::hypot(xx - yy, 2 * xy) / (2 * all)};
}

struct Stretch {
  std::size_t first;
  std::size_t last;
};

struct Candidate {
  Edge edge{};
  bool is_wide = false;
  bool is_used = false;
};

class LoopCloser {
 public:
  LoopCloser(Track& track, Loops& loops, bool is_first)
      : track_(track), loops_(loops), is_first_(is_first), uncertainty_(track, loops.edges) {}

  // Matches the keyframe's stretch against all places that it may be near.
  void look(std::size_t at) {
    uncertainty_.look_from(at);
    auto near = places(at);
    double widest = 0;
    for (const std::size_t place : near)
      widest = std::max(widest, uncertainty_.window(place).distance);
    if (near.empty()) return;
    if (widest <= kWide) {
      if (near.size() > kPlacesMax) near.resize(kPlacesMax);
      look_near(at, near);
    } else if (travelled(at) - looked_far_at_ >= far_every(widest)) {
      looked_far_at_ = travelled(at);
      if (near.size() > kWidePlacesMax) near.resize(kWidePlacesMax);
      look_far(at, near);
    }
    const bool much = unused_ > 0 && most_off_ > kFarOff;
    if (much || unused_ >= kAtOnce) close();
  }
  void close() {
    if (unused_ == 0) return;
    (void)optimise(all_edges(track_, loops_), track_.poses, Doubt::kNotAtFirst);
    uncertainty_ = Uncertainty(track_, loops_.edges);
    unused_ = 0;
    most_off_ = 0;
  }
  // The number of loops that do not hold after all of them were closed.
  std::size_t remove_wrong() {
    const std::size_t removed = std::erase_if(loops_.edges, [&](const Edge& edge) {
      const Pose off = (track_.poses[edge.to] - track_.poses[edge.from]) - edge.step;
      if (length_of(off) > kClosedOff || std::abs(signed_angle(off.rho)) > kClosedTurn) return true;
      const Stretch here = around(edge.to, kLoopsStretch);
      const Stretch there = around(edge.from, kPlace);
      return agreement(here, there, track_.poses[edge.to], track_.poses[edge.to]).contradiction() >
             kClosedContradictionMost;
    });
    loops_.removed += removed;
    if (removed > 0) {
      unused_ = 1;
      close();
    }
    return removed;
  }

 private:
  [[nodiscard]] double travelled(std::size_t at) const { return track_.keyframes[at].travelled; }

  [[nodiscard]] Stretch around(std::size_t at, double reach) const {
    const std::size_t scans_max = static_cast<std::size_t>(reach / 100) + 40;
    Stretch stretch{at, at};
    while (stretch.first > 0 && travelled(at) - travelled(stretch.first - 1) <= reach &&
           at - stretch.first < scans_max)
      --stretch.first;
    while (stretch.last + 1 < track_.poses.size() &&
           travelled(stretch.last + 1) - travelled(at) <= reach && stretch.last - at < scans_max)
      ++stretch.last;
    return stretch;
  }

  // mm of travel between searches in large windows: most of them fail again in the second pass.
  [[nodiscard]] double far_every(double widest) const {
    return (is_first_ ? 1 : 2) * std::min(kWideEvery * widest, kWideEveryMost);
  }

  // The nearest keyframe of each pass, and the nearest of those.
  [[nodiscard]] std::vector<std::size_t> places(std::size_t at) const {
    std::vector<std::pair<double, std::size_t>> passes;
    bool inside = false;
    for (std::size_t i = 0; i < at && travelled(at) - travelled(i) > kLoopsGap; ++i) {
      const double off = length_of(track_.poses[i] - track_.poses[at]);
      const double reach = uncertainty_.window(i).distance + kLoopsSeen;
      if (off > reach || (!is_first_ && uncertainty_.way(i) < kLinkedWay)) {
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
    for (const auto& [off, i] : passes) found.push_back(i);
    return found;
  }

  // Earlier than what is looked for, so that the stretch does not find itself.
  [[nodiscard]] Stretch place_around(std::size_t place, double reach, std::size_t at) const {
    Stretch stretch = around(place, reach);
    while (stretch.last > place && travelled(at) - travelled(stretch.last) < kLoopsGap / 2)
      --stretch.last;
    return stretch;
  }

  void look_near(std::size_t at, std::span<const std::size_t> near) {
    const Stretch stretch = around(at, kLoopsStretch);
    const auto points = points_around(track_, stretch.first, stretch.last, track_.poses[at]);
    auto few = thinned(points, kGrain);
    std::erase_if(few, [](const ScanPoint2d& p) {
      return static_cast<double>(std::hypot(p.x, p.y)) > kNearView - kPlace;
    });
    for (const std::size_t place : near) {
      ++loops_.tried;
      const Stretch there = place_around(place, kPlace, at);
      const auto others = points_around(track_, there.first, there.last, track_.poses[place]);
      const auto found = ScanSearch(near_points(there, track_.poses[place], kNearView))
                             .find(few, track_.poses[at] - track_.poses[place],
                                   uncertainty_.window(place), kLoopsScoreLeast);
      if (!found) continue;
      const auto edge =
          verified(at, place, points, others, found->pose, kLoopsStretch, kLoopsShareLeast);
      if (edge) consider({.edge = *edge});
    }
  }

  // The match at a pose, if it holds.
  [[nodiscard]] std::optional<Edge> verified(std::size_t at, std::size_t place,
                                             std::span<const ScanPoint2d> points,
                                             std::span<const ScanPoint2d> others, const Pose& pose,
                                             double reach, double share_least) const {
    const PointIndex index(others);
    const auto matched = match(index, points, pose);
    if (!matched || matched->share < kMatchShareLeast || matched->misfit > kLoopsMisfitMost)
      return std::nullopt;
    const Stretch here = around(at, reach);
    const Stretch there = place_around(place, kPlace + reach - kLoopsStretch, at);
    Edge edge{place, at, matched->pose, matched->information};
    const Weakest weakest = weakest_of(others);
    const Covered covered = covered_points(edge, here, there, index, weakest);
    if (covered.all.share() < share_least || covered.part() < kLoopsCoveredLeast)
      return std::nullopt;
    if (static_cast<double>(covered.weak.covered) <
        kWeakLeast * static_cast<double>(covered.all.covered)) {
      forget(weakest, edge.information);
    } else if (covered.weak.share() < share_least - kWeakMargin) {
      return std::nullopt;
    }
    const Pose by_loop = track_.poses[place] + matched->pose;
    if (agreement(here, there, track_.poses[at], by_loop).contradiction() > kContradictionMost)
      return std::nullopt;
    return edge;
  }

  // Removes what a match knows about a direction.
  static void forget(const Weakest& weakest, Information& information) {
    const Eigen::Vector3d along(weakest.x, weakest.y, 0);
    const Information rest = Information::Identity() - along * along.transpose();
    information = rest * information * rest;
  }

  // Points of a stretch that another one can have seen: not what is behind its walls.
  struct Count {
    std::size_t covered = 0;
    std::size_t on_wall = 0;

    [[nodiscard]] double share() const {
      return static_cast<double>(on_wall) / static_cast<double>(std::max<std::size_t>(covered, 1));
    }
  };
  struct Covered {
    std::size_t points = 0;
    Count all{};
    Count weak{};  // that determine the weakest direction

    [[nodiscard]] double part() const {
      return static_cast<double>(all.covered) /
             static_cast<double>(std::max<std::size_t>(points, 1));
    }
  };
  [[nodiscard]] Covered covered_points(const Edge& edge, const Stretch& here, const Stretch& there,
                                       const PointIndex& index, const Weakest& weakest) const {
    const auto views = some_of(there);
    Covered covered;
    std::vector<ScanPoint2d> points;
    for (const std::size_t i : some_of(here)) {
      points.clear();
      add_points(track_.keyframes[i].points, edge.step + (track_.poses[i] - track_.poses[edge.to]),
                 points);
      for (const ScanPoint2d& p : points) {
        if (!p.on_wall()) continue;
        ++covered.points;
        const bool on_wall = index.nearest(p, kOnWall) != nullptr;
        const auto is_seen = [&](std::size_t j) {
          const Pose seen = track_.poses[edge.from] +
                            Pose{.x = static_cast<double>(p.x), .y = static_cast<double>(p.y)} -
                            track_.poses[j];
          return track_.keyframes[j].view.judge(seen.x, seen.y) != Seen::kUnknown;
        };
        if (!on_wall && std::ranges::none_of(views, is_seen)) continue;
        const auto count = [&](Count& of) {
          ++of.covered;
          if (on_wall) ++of.on_wall;
        };
        count(covered.all);
        if (weakest.is_determined_by(p)) count(covered.weak);
      }
    }
    return covered;
  }

  // Scans of a stretch that see all of it.
  [[nodiscard]] std::vector<std::size_t> some_of(const Stretch& stretch) const {
    std::vector<std::size_t> keyframes;
    for (std::size_t i = stretch.first; i <= stretch.last; ++i)
      if (keyframes.empty() || travelled(i) - travelled(keyframes.back()) >= kViewEvery)
        keyframes.push_back(i);
    return keyframes;
  }

  // Whether scans of two stretches see through each other's walls, when `is` of the first stretch
  // is moved to `should`.
  [[nodiscard]] Agreement agreement(const Stretch& here, const Stretch& there, const Pose& is,
                                    const Pose& should) const {
    const auto others = some_of(there);
    Agreement all;
    for (const std::size_t i : some_of(here)) {
      const Pose pose = should + (track_.poses[i] - is);
      for (const std::size_t j : others) {
        const Pose step = track_.poses[j] - pose;
        if (length_of(step) > kWideView) continue;
        all.add(track_.keyframes[i].view.judge(track_.keyframes[j].points, step));
        all.add(track_.keyframes[j].view.judge(track_.keyframes[i].points, pose - track_.poses[j]));
      }
    }
    return all;
  }

  struct Fit {
    Edge edge;
    double score;
  };

  // The points of a stretch that are not far from it.
  [[nodiscard]] std::vector<ScanPoint2d> near_points(const Stretch& stretch, const Pose& frame,
                                                     double reach) const {
    auto points = points_around(track_, stretch.first, stretch.last, frame);
    std::erase_if(points, [&](const ScanPoint2d& p) {
      return static_cast<double>(std::hypot(p.x, p.y)) > reach;
    });
    return points;
  }

  void look_far(std::size_t at, std::span<const std::size_t> near) {
    const Stretch stretch = around(at, kWideStretch);
    const auto points =
        thinned(near_points(stretch, track_.poses[at], kWideStretch + kWideView), kGrain / 2);
    if (weakest_of(points).share < kAcrossLeast) return;
    const auto few = thinned(points, kWideGrain);
    std::vector<Fit> fits;
    double best = kWideScoreLeast;
    for (const std::size_t place : near) {
      ++loops_.tried;
      const Stretch there = place_around(place, kWidePlace, at);
      const auto others = near_points(there, track_.poses[place], kWidePlace + kWideView);
      const ScanSearch search(others, kWideCell, kWideLevels);
      const Pose middle = track_.poses[at] - track_.poses[place];
      const Window window = uncertainty_.window(place);
      const auto found = search.find(few, middle, window, std::max(kWideScoreLeast, kAlike * best));
      if (!found) continue;
      add_fit(at, place, points, others, *found, fits);
      const auto other =
          search.find(few, middle, window, kAlike * found->score, {found->pose, kOtherPlace});
      if (other) add_fit(at, place, points, others, *other, fits);
      best = std::max(best, found->score);
    }
    if (const Fit* only = only_place(fits)) consider({.edge = only->edge, .is_wide = true});
  }

  void add_fit(std::size_t at, std::size_t place, std::span<const ScanPoint2d> points,
               std::span<const ScanPoint2d> others, const ScanSearch::Found& found,
               std::vector<Fit>& fits) const {
    const auto edge =
        verified(at, place, points, others, found.pose, kWideStretch, kWideShareLeast);
    if (edge) fits.push_back({*edge, found.score});
  }

  // The best fit, if nothing elsewhere fits about as well.
  [[nodiscard]] const Fit* only_place(const std::vector<Fit>& fits) const {
    const auto best = std::ranges::max_element(fits, {}, &Fit::score);
    if (best == fits.end()) return nullptr;
    const Pose there = track_.poses[best->edge.from] + best->edge.step;
    for (const Fit& fit : fits) {
      const Pose other = track_.poses[fit.edge.from] + fit.edge.step;
      if (fit.score >= kAlike * best->score && length_of(other - there) > kOtherPlace)
        return nullptr;
    }
    return &*best;
  }

  void consider(Candidate candidate) {
    ++loops_.found;
    found_.push_back(std::move(candidate));
    Candidate& now = found_.back();
    std::size_t agreeing = 0;
    std::size_t rivals = 0;
    for (const Candidate& other : recent()) {
      if (agree(now, other)) {
        ++agreeing;
      } else if (contradict(now, other)) {
        rivals = std::max(rivals, supporters(other));
      }
    }
    const bool is_wide = now.is_wide;
    if (agreeing < (is_wide ? kWideAgreeLeast : 1) || (is_wide && agreeing <= 2 * rivals)) return;
    for (Candidate& other : recent())
      if (!other.is_used && agree(now, other)) use(other);
    use(now);
  }

  // The candidates before the last one that can agree with it or contradict it.
  [[nodiscard]] std::span<Candidate> recent() {
    std::size_t first = found_.size() - 1;
    while (first > 0 && std::abs(travelled(found_.back().edge.to) -
                                 travelled(found_[first - 1].edge.to)) <= kWideSecondMost)
      --first;
    return std::span(found_).subspan(first, found_.size() - 1 - first);
  }
  [[nodiscard]] std::size_t supporters(const Candidate& of) {
    return static_cast<std::size_t>(
        std::ranges::count_if(recent(), [&](const Candidate& other) { return agree(of, other); }));
  }

  void use(Candidate& candidate) {
    const Edge& edge = candidate.edge;
    candidate.is_used = true;
    const Pose is = track_.poses[edge.to] - track_.poses[edge.from];
    most_off_ = std::max(most_off_, length_of(is - edge.step));
    loops_.edges.push_back(edge);
    ++unused_;
  }

  // The pose of the one's end by the other, in the frame of the one's begin, relative to its own.
  [[nodiscard]] Pose difference(const Edge& a, const Edge& b) const {
    const auto& poses = track_.poses;
    const Pose by_b = (poses[b.from] - poses[a.from]) + b.step + (poses[a.to] - poses[b.to]);
    return by_b - a.step;
  }

  [[nodiscard]] bool agree(const Candidate& one, const Candidate& other) const {
    const Edge& a = one.edge;
    const Edge& b = other.edge;
    const bool is_wide = one.is_wide || other.is_wide;
    const double apart = std::abs(travelled(a.to) - travelled(b.to));
    if (apart < kSecondDistanceLeast || apart > (is_wide ? kWideSecondMost : kSecondDistanceMost))
      return false;
    if (!is_wide && std::abs(travelled(a.from) - travelled(b.from)) > kSecondPlaceMost)
      return false;
    const Pose off = difference(a, b);
    const double same = is_wide ? kWideSameDistance + kWideSameByDistance * apart : kSameDistance;
    return length_of(off) <= same &&
           std::abs(signed_angle(off.rho)) <= (is_wide ? kWideSameTurn : kSameTurn);
  }
  [[nodiscard]] bool contradict(const Candidate& one, const Candidate& other) const {
    const double apart = std::abs(travelled(one.edge.to) - travelled(other.edge.to));
    const Pose off = difference(one.edge, other.edge);
    return length_of(off) > 2 * (kWideSameDistance + kWideSameByDistance * apart) ||
           std::abs(signed_angle(off.rho)) > 2 * kWideSameTurn;
  }

  Track& track_;
  Loops& loops_;
  bool is_first_;
  Uncertainty uncertainty_;
  std::vector<Candidate> found_;
  double looked_far_at_ = -1e9;  // mm of travel
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
  Loops loops;
  for (int pass = 0; pass < kPassesMost; ++pass) {
    LoopCloser closer(track, loops, pass == 0);
    const std::size_t before = loops.edges.size();
    double looked_at = 0;
    for (std::size_t i = 0; i < track.keyframes.size(); ++i) {
      if (track.keyframes[i].travelled - looked_at < kEvery) continue;
      looked_at = track.keyframes[i].travelled;
      const std::string_view what = pass == 0 ? "closing loops" : "closing loops that were missed";
      if (!progress(what, i, track.keyframes.size())) return std::nullopt;
      closer.look(i);
    }
    closer.close();
    const std::size_t added = loops.edges.size() - before;
    if (closer.remove_wrong() == 0 && added == 0) break;
  }
  return loops;
}

}  // namespace rack::mapping
