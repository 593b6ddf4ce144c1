#include "components/localisation/localiser.h"

#include <cmath>

namespace rack::localisation {

namespace {

constexpr double kSettled = 0.99;          // of the weight, in one place
constexpr double kBelieved = 0.5;          // of the weight; below, most of it is elsewhere
constexpr double kFavoured = 0.2;          // of the weight, kept at the settled place
constexpr std::uint32_t kDoubtsMost = 12;  // scans, until the other place is accepted
constexpr double kBlocked = 0.07;          // of the beams
constexpr double kSearching = 0.1;         // of the cloud, where nothing is known to fit
constexpr double kPushed = 0.03;           // of the beams
constexpr std::uint32_t kHiddenMost = 20;  // scans while moving
constexpr std::uint32_t kAtRestMost = 12;  // scans
// Deviations of a rival's pose when it takes over.
constexpr double kClimbed = 150;      // mm
constexpr double kClimbedTurn = 0.1;  // rad

bool is_pose(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.rho);
}

Estimate estimate_at(const Pose& pose, double deviation, double deviation_rho) {
  const double square = deviation * deviation;
  return {.pose = pose,
          .covariance = {.xx = square, .yy = square, .rho_rho = deviation_rho * deviation_rho}};
}

}  // namespace

Localiser::Localiser(const LocaliserSettings& settings, std::uint64_t seed)
    : settings_(settings),
      filter_(settings.filter, seed),
      rivals_(settings.filter.sharpness),
      random_(~seed) {
  settings_.beams = std::max(1U, settings.beams);
  beams_.reserve(settings_.beams);
}

void Localiser::start_at(const Pose& pose, double deviation, double deviation_rho) {
  filter_.start_at(pose, deviation, deviation_rho);
  estimate_ = estimate_at(pose, deviation, deviation_rho);
  first_ = true;
  anywhere_ = false;
  found_ = false;
  settled_ = false;
  rivals_.clear();
}

void Localiser::start_anywhere() {
  anywhere_ = true;
  first_ = true;
  found_ = true;
  settled_ = false;
  rivals_.clear();
}

bool Localiser::take(const LikelihoodField& field, const Pose& odometry,
                     std::span<const BeamEnd> scan, const WallLines* walls) {
  if (!is_pose(odometry)) return false;
  odometry_ = odometry;
  if (first_) taken_ = odometry;
  const Pose step = odometry - taken_;
  const bool moved = std::hypot(step.x, step.y) >= settings_.distance_between ||
                     std::abs(signed_angle(step.rho)) >= settings_.turn_between;
  choose(scan);
  if (beams_.empty()) return false;
  if (!first_ && !moved && !is_worth_it_at_rest(field)) return false;
  const Pose expected = pose();
  at_rest_ = moved ? 0 : at_rest_ + 1;
  taken_ = odometry;
  if (first_ && anywhere_) filter_.start_anywhere(field, beams_);
  if (!first_) filter_.move(step);
  first_ = false;
  filter_.weigh(field, beams_);
  estimate_ = estimate_from(field, expected);
  if (const auto winner = compare_rivals(field, step)) go_on_at(*winner);
  if (walls != nullptr)
    if (const auto refined = matcher_.refined(*walls, scan, estimate_)) estimate_ = *refined;
  rivals_.widen(estimate_);
  if (!settled_) estimate_.share = std::min(estimate_.share, kBelieved);
  const bool is_impossible = !settled_ && field.blocked(estimate_.pose, beams_) > kBlocked;
  const bool may_have_jumped = moved || !settled_ || field.blocked(expected, beams_) > kPushed;
  filter_.resample(field, beams_,
                   {.anywhere = has_to_search(field, moved),
                    .nearby = may_have_jumped,
                    .least = is_impossible ? kSearching : 0});
  if (!settled_ && filter_.injected() > 0) found_ = true;
  return true;
}

// At rest, each scan repeats the same measurement; only some of them can help a cloud to settle.
bool Localiser::is_worth_it_at_rest(const LikelihoodField& field) const {
  return filter_.misfits(field.fit(pose(), beams_)) || (!settled_ && at_rest_ < kAtRestMost);
}

std::optional<Pose> Localiser::compare_rivals(const LikelihoodField& field, const Pose& step) {
  if (!settled_) {
    rivals_.clear();
    return std::nullopt;
  }
  if (!settles_) return rivals_.take(field, beams_, step, estimate_.pose);
  if (found_) rivals_.search(field, beams_, estimate_.pose, random_);
  return std::nullopt;
}

void Localiser::go_on_at(const Pose& pose) {
  filter_.start_at(pose, kClimbed, kClimbedTurn);
  estimate_ = estimate_at(pose, kClimbed, kClimbedTurn);
  estimate_.share = 1;
}

// Only when the robot cannot be where it has settled.
bool Localiser::has_to_search(const LikelihoodField& field, bool moved) {
  if (!settled_ || filter_.searching_share() == 0) {
    hidden_ = 0;
    return true;
  }
  if (field.blocked(estimate_.pose, beams_) > kBlocked) return true;
  return moved && ++hidden_ > kHiddenMost;
}

// The noise of a part of a step of the filter: variances grow linearly with the distance, standard
// deviations do not.
Estimate Localiser::now() const {
  const Pose step = odometry_ - taken_;
  const double distance = std::hypot(step.x, step.y);
  const double turn = std::abs(signed_angle(step.rho));
  const double part =
      std::min(1.0, std::max(distance / settings_.distance_between, turn / settings_.turn_between));
  Estimate now = estimate_;
  now.pose = pose();
  if (!(part > 0)) return now;
  const StepNoise noise = noise_of(settings_.filter, distance / part, turn / part);
  const double slips = settings_.filter.slip_times * settings_.filter.slip_times;
  const double more = part * (1 + settings_.filter.slip_share * (slips - 1));
  const double dx = now.pose.x - estimate_.pose.x;
  const double dy = now.pose.y - estimate_.pose.y;
  const double c = std::cos(estimate_.pose.rho);
  const double s = std::sin(estimate_.pose.rho);
  const double along = more * noise.along * noise.along;
  const double across = more * noise.across * noise.across;
  Covariance& now_is = now.covariance;
  const Covariance was = estimate_.covariance;
  // The direction of the step depends on the heading, so the covariance of the heading enters the
  // position.
  now_is.xx = was.xx - 2 * dy * was.x_rho + dy * dy * was.rho_rho + c * c * along + s * s * across;
  now_is.yy = was.yy + 2 * dx * was.y_rho + dx * dx * was.rho_rho + s * s * along + c * c * across;
  now_is.xy =
      was.xy + dx * was.x_rho - dy * was.y_rho - dx * dy * was.rho_rho + c * s * (along - across);
  now_is.x_rho = was.x_rho - dy * was.rho_rho;
  now_is.y_rho = was.y_rho + dx * was.rho_rho;
  now_is.rho_rho = was.rho_rho + more * noise.turn * noise.turn;
  return now;
}

Estimate Localiser::estimate_from(const LikelihoodField& field, const Pose& expected) {
  settles_ = false;
  if (settled_) {
    const Estimate here = filter_.estimate_near(expected);
    doubts_ = here.share >= kBelieved ? 0 : doubts_ + 1;
    if (here.share > 0 && doubts_ <= kDoubtsMost) {
      filter_.favour(here.pose, kFavoured);
      return here;
    }
    found_ = true;
  }
  doubts_ = 0;
  const Estimate heaviest = filter_.estimate();
  settled_ = settles_ =
      heaviest.share >= kSettled && field.blocked(heaviest.pose, beams_) <= kBlocked;
  return heaviest;
}

void Localiser::choose(std::span<const BeamEnd> scan) {
  beams_.clear();
  if (scan.empty()) return;
  const double every = std::max(1.0, static_cast<double>(scan.size()) / settings_.beams);
  const double first = every > 1 ? every * static_cast<double>(random_.uniform()) : 0;
  for (std::uint32_t i = 0; i < settings_.beams; ++i) {
    const auto at = static_cast<std::size_t>(first + i * every);
    if (at >= scan.size()) break;
    if (std::isfinite(scan[at].x) && std::isfinite(scan[at].y)) beams_.add(scan[at]);
  }
}

}  // namespace rack::localisation
