#include "components/localisation/heading_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::localisation {

namespace {

constexpr std::size_t kBeams = 90;
constexpr double kReach = 2;         // standard deviations
constexpr double kLengthStep = 250;  // mm
constexpr int kLengthStepsMax = 12;  // on each side; larger areas get larger steps
constexpr double kTurnStep = radians(2.0);
constexpr double kOther = radians(20.0);  // a heading that differs more is another one
constexpr double kFits = 0.4;
constexpr double kClearer = 0.05;

Beams some_of(std::span<const BeamEnd> scan) {
  Beams beams;
  const std::size_t every = std::max<std::size_t>(1, scan.size() / kBeams);
  for (std::size_t i = 0; i < scan.size(); i += every)
    if (std::isfinite(scan[i].x) && std::isfinite(scan[i].y)) beams.add(scan[i]);
  return beams;
}

// Calls `visit` with each pose of a grid.
template <typename Visit>
void for_each(const Pose& middle, int lengths, double length_step, int turns, double turn_step,
              Visit visit) {
  for (int turn = -turns; turn <= turns; ++turn)
    for (int x = -lengths; x <= lengths; ++x)
      for (int y = -lengths; y <= lengths; ++y)
        visit(Pose{.x = middle.x + x * length_step,
                   .y = middle.y + y * length_step,
                   .rho = heading(middle.rho + turn * turn_step)});
}

}  // namespace

bool HeadingSearch::is_clear() const { return fit >= kFits && fit >= rival_fit + kClearer; }

std::optional<HeadingSearch> find_heading(const LikelihoodField& field,
                                          std::span<const BeamEnd> scan, const Pose& place,
                                          double deviation) {
  const Beams beams = some_of(scan);
  if (beams.empty()) return std::nullopt;
  const double reach = std::isfinite(deviation) ? kReach * std::max(deviation, 0.0) : 0;
  const int lengths =
      std::clamp(static_cast<int>(std::min(reach / kLengthStep, 1e6)), 1, kLengthStepsMax);
  const double step = std::max(kLengthStep, reach / lengths);
  constexpr int kTurns = static_cast<int>(kPi / kTurnStep);
  HeadingSearch found;
  std::array<double, 2 * kTurns + 1> best_of_heading{};
  const auto index = [](double rho) {
    const auto turn = static_cast<int>(std::lround(signed_angle(rho) / kTurnStep));
    return static_cast<std::size_t>(std::clamp(turn + kTurns, 0, 2 * kTurns));
  };
  for_each({.x = place.x, .y = place.y, .rho = 0}, lengths, step, kTurns, kTurnStep,
           [&](const Pose& pose) {
             if (!field.is_free(pose.x, pose.y)) return;
             const double fit = field.fit(pose, beams);
             double& best = best_of_heading[index(pose.rho)];
             best = std::max(best, fit);
             if (fit > found.fit) found = {.pose = pose, .fit = fit};
           });
  for (int turn = -kTurns; turn <= kTurns; ++turn) {
    const double rho = turn * kTurnStep;
    if (std::abs(signed_angle(rho - found.pose.rho)) > kOther)
      found.rival_fit = std::max(found.rival_fit, best_of_heading[index(rho)]);
  }
  constexpr int kFiner = 4;
  for_each(Pose(found.pose), kFiner, step / kFiner, kFiner, kTurnStep / kFiner,
           [&](const Pose& pose) {
             const double fit = field.fit(pose, beams);
             if (fit <= found.fit) return;
             found.fit = fit;
             found.pose = pose;
           });
  return found;
}

}  // namespace rack::localisation
