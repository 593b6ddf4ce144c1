#include "components/localisation/rivals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::localisation {

namespace {

// One draw for each square of this size and each of this many headings.
constexpr double kDrawSquare = 250 * 250;  // mm^2
constexpr double kDrawHeadings = 24;
constexpr double kDrawsLeast = 20'000;
constexpr double kDrawsMost = 400'000;  // a search takes some 50 ms
constexpr std::size_t kBest = 400;      // draws from which the search climbs

constexpr double kSimilar = 0.05;     // difference of scores that one scan does not decide
constexpr double kDecided = 4;        // evidence: odds of 50 to 1
constexpr double kRemembered = 0.97;  // of the evidence, at the next scan
constexpr double kSamePlace = 1000;   // mm
constexpr double kSameHeading = kPi / 6;

struct Climber {
  Pose pose;
  double fit = 0;

  bool try_step(const LikelihoodField& field, const Beams& beams, const Pose& to) {
    const double at = field.fit(to, beams);
    if (at <= fit) return false;
    pose = to;
    fit = at;
    return true;
  }
};

// Climbs along the axes with steps that are halved when none of them leads higher.
Climber climbed(const LikelihoodField& field, const Beams& beams, const Pose& from) {
  constexpr std::array<double, 4> kSteps = {120, 60, 30, 15};  // mm
  constexpr double kTurnPerStep = 0.0005;                      // rad for each mm
  constexpr int kRoundsOfStep = 4;
  Climber climber{from, field.fit(from, beams)};
  for (const double step : kSteps) {
    bool higher = true;
    for (int round = 0; round < kRoundsOfStep && higher; ++round) {
      higher = false;
      for (const double by : {-step, step}) {
        const Pose& at = climber.pose;
        higher |= climber.try_step(field, beams, {.x = at.x + by, .y = at.y, .rho = at.rho});
        higher |= climber.try_step(field, beams, {.x = at.x, .y = at.y + by, .rho = at.rho});
        higher |= climber.try_step(
            field, beams, {.x = at.x, .y = at.y, .rho = heading(at.rho + kTurnPerStep * by)});
      }
    }
  }
  return climber;
}

// A beam through a wall is worse than one that only does not fit.
double score(const LikelihoodField& field, const Beams& beams, const Climber& climber) {
  return climber.fit - field.blocked(climber.pose, beams);
}

bool is_same(const Pose& a, const Pose& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kSamePlace &&
         std::abs(signed_angle(a.rho - b.rho)) < kSameHeading;
}

}  // namespace

Rivals::Rivals(double sharpness) : sharpness_(sharpness) {
  rivals_.reserve(kMost);
  best_.reserve(kBest);
}

void Rivals::search(const LikelihoodField& field, const Beams& beams, const Pose& settled,
                    Random& random) {
  rivals_.clear();
  if (beams.empty()) return;
  draw(field, beams, random);
  const Climber here = climbed(field, beams, settled);
  const double to_reach = score(field, beams, here) - kSimilar;
  std::ranges::sort(best_, std::ranges::greater{}, &Draw::sum);
  for (const Draw& draw : best_) {
    const Pose from{.x = draw.x, .y = draw.y, .rho = draw.rho};
    if (rivals_.size() == kMost) return;
    if (is_known(from, here.pose)) continue;
    const Climber there = climbed(field, beams, from);
    if (there.fit < to_reach || is_known(there.pose, here.pose)) continue;
    if (score(field, beams, there) >= to_reach) rivals_.push_back({there.pose});
  }
}

// Of uniform draws in free space, those that fit best.
void Rivals::draw(const LikelihoodField& field, const Beams& beams, Random& random) {
  const double area =
      static_cast<double>(field.free_cells()) * field.resolution() * field.resolution();
  const auto draws = static_cast<std::size_t>(
      std::clamp(kDrawHeadings * area / kDrawSquare, kDrawsLeast, kDrawsMost));
  best_.clear();
  for (std::size_t i = 0; i < draws; ++i) {
    const MapPoint place = field.draw_free(random);
    Draw draw{.x = static_cast<float>(place.x),
              .y = static_cast<float>(place.y),
              .rho = random.uniform(0, static_cast<float>(2 * kPi))};
    draw.sum = field.sum(draw.x, draw.y, std::sin(draw.rho), std::cos(draw.rho), beams);
    if (best_.size() == kBest) {
      if (draw.sum <= best_.front().sum) continue;
      std::ranges::pop_heap(best_, std::ranges::greater{}, &Draw::sum);
      best_.pop_back();
    }
    best_.push_back(draw);
    std::ranges::push_heap(best_, std::ranges::greater{}, &Draw::sum);
  }
}

std::optional<Pose> Rivals::take(const LikelihoodField& field, const Beams& beams, const Pose& step,
                                 const Pose& settled) {
  if (rivals_.empty() || beams.empty()) return std::nullopt;
  const Climber here = climbed(field, beams, settled);
  const double score_here = score(field, beams, here);
  for (Rival& rival : rivals_) {
    const Climber there = climbed(field, beams, rival.pose + step);
    rival.pose = there.pose;
    const double better = score(field, beams, there) - score_here;
    rival.evidence = kRemembered * rival.evidence + sharpness_ * better;
  }
  std::erase_if(rivals_, [&](const Rival& rival) {
    return rival.evidence <= -kDecided || is_same(rival.pose, here.pose);
  });
  const auto best = std::ranges::max_element(rivals_, {}, &Rival::evidence);
  if (best == rivals_.end() || best->evidence < kDecided) return std::nullopt;
  const Pose winner = best->pose;
  for (Rival& rival : rivals_) rival.evidence -= kDecided;
  *best = {here.pose, 0};
  std::erase_if(rivals_, [](const Rival& rival) { return rival.evidence <= -kDecided; });
  return winner;
}

void Rivals::widen(Estimate& estimate) const {
  if (rivals_.empty()) return;
  const double share = 1 / static_cast<double>(rivals_.size() + 1);
  Covariance& sum = estimate.covariance;
  for (const Rival& rival : rivals_) {
    const double dx = rival.pose.x - estimate.pose.x;
    const double dy = rival.pose.y - estimate.pose.y;
    const double turn = signed_angle(rival.pose.rho - estimate.pose.rho);
    sum.xx += share * dx * dx;
    sum.xy += share * dx * dy;
    sum.yy += share * dy * dy;
    sum.x_rho += share * dx * turn;
    sum.y_rho += share * dy * turn;
    sum.rho_rho += share * turn * turn;
  }
  estimate.share *= share;
}

bool Rivals::is_known(const Pose& pose, const Pose& settled) const {
  return is_same(pose, settled) || std::ranges::any_of(rivals_, [&](const Rival& rival) {
           return is_same(pose, rival.pose);
         });
}

}  // namespace rack::localisation
