#include "components/localisation/position_updates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "components/localisation/mcl_messages.h"

namespace rack::localisation {

namespace {

constexpr double kFollowedDeviation = 200;  // mm, at least

double deviation_of(const PositionData& position) {
  return std::max(position.var.x.raw(), position.var.y.raw());
}

}  // namespace

bool PositionUpdates::may_start_at(const PositionData& position, const Pose& odometry,
                                   double deviation, double deviation_rho) {
  return deviation_of(position) <= kKnown ||
         (std::hypot(odometry.x, odometry.y) <= deviation &&
          std::abs(signed_angle(odometry.rho)) <= deviation_rho);
}

PositionUpdates::Step PositionUpdates::take(Localiser& localiser, const Pose& odometry,
                                            const std::optional<PositionData>& believed,
                                            TimeStamp time, const KnowsTime& knows_time) {
  Step step;
  if (believed) {
    const Look look{Pose::of(believed->pos), odometry, time};
    const bool jumped = has_jumped(look, knows_time);
    last_ = look;
    if (jumped) {
      if (const auto away = followed(localiser, *believed)) {
        was_sure_ = false;
        return {.event = Event::kFollows, .away = *away};
      }
    }
  }
  const bool is_sure = localisation::is_sure(localiser.now(), kCertain);
  if (std::exchange(was_sure_, is_sure) != is_sure)
    step.event = is_sure ? Event::kCertain : Event::kUncertain;
  PositionData update = to_update(localiser, time);
  if (!is_sure) {
    if (!believed || deviation_of(*believed) > kCertain) return step;
    update.pos = believed->pos;
    update.var.x = std::max<i32>(update.var.x, kLostDeviation);
    update.var.y = std::max<i32>(update.var.y, kLostDeviation);
  }
  last_ = {Pose::of(update.pos), odometry, time};
  step.update = update;
  return step;
}

bool PositionUpdates::has_jumped(const Look& now, const KnowsTime& knows_time) const {
  if (!last_) return false;
  const Pose expected = last_->position + (now.odometry - last_->odometry);
  const double jump = std::hypot(now.position.x - expected.x, now.position.y - expected.y);
  return jump > kJump && knows_time(last_->time);
}

// The distance to the place where the localiser now searches; empty: it stays where it is.
std::optional<double> PositionUpdates::followed(Localiser& localiser,
                                                const PositionData& believed) {
  const Pose there = Pose::of(believed.pos);
  const Pose here = localiser.pose();
  const double deviation = deviation_of(believed);
  const double away = std::hypot(there.x - here.x, there.y - here.y);
  if (deviation > kCertain || away < kJump + 3 * deviation) return std::nullopt;
  localiser.start_at(there, std::max(deviation, kFollowedDeviation), kFollowedTurn);
  return away;
}

}  // namespace rack::localisation
