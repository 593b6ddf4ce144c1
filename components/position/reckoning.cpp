#include "components/position/reckoning.h"

#include <algorithm>
#include <cmath>

namespace rack::navigation {

namespace {

constexpr double kJitter = 0.3;   // of a period: time stamps are not exact
constexpr double kDrives = 50;    // mm/s; slower movements do not state their duration
constexpr double kRotates = 0.1;  // rad/s

bool is_finite(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.rho);
}

double seconds_of(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

// How long a movement took, s; at most `gap`, which is also the answer for a vehicle at rest.
double time_of(const ChassisData& movement, double gap) {
  const double driven = std::hypot(movement.deltaX.raw(), movement.deltaY.raw());
  const double speed = std::hypot(movement.vx.raw(), movement.vy.raw());
  const double turned = std::abs(movement.deltaRho.raw());
  const double rate = std::abs(movement.omega.raw());
  double time = gap;
  if (speed > kDrives)
    time = driven / speed;
  else if (rate > kRotates)
    time = turned / rate;
  return std::isfinite(time) ? std::min(time, gap) : gap;
}

}  // namespace

OdometryData DeadReckoning::add(const ChassisData& movement) {
  const Pose step{.x = movement.deltaX, .y = movement.deltaY, .rho = movement.deltaRho};
  if (is_finite(step)) {
    pose_ = pose_ + lost_before(movement) + step;
    newest_ = movement;
  }
  return {.recordingTime = movement.recordingTime, .pos = pose_.position()};
}

// The movement between the previous data and the beginning of this one.
Pose DeadReckoning::lost_before(const ChassisData& movement) const {
  if (!newest_) return {};
  const double gap = seconds_of(movement.recordingTime - newest_->recordingTime);
  if (!(gap > 0) || gap > seconds_of(kLongestGap)) return {};
  const double missing = gap - time_of(movement, gap);
  if (missing < gap * kJitter) return {};
  const auto mean = [missing](double before, double now) { return missing * (before + now) / 2; };
  const Pose lost{.x = mean(newest_->vx, movement.vx),
                  .y = mean(newest_->vy, movement.vy),
                  .rho = mean(newest_->omega, movement.omega)};
  return is_finite(lost) ? lost : Pose{};
}

namespace {

template <typename Data>
Position3d pose_at(const Data& before, const Data& after, TimeStamp time) {
  const double all = static_cast<double>((after.recordingTime - before.recordingTime).count());
  const double part =
      all == 0 ? 0 : static_cast<double>((time - before.recordingTime).count()) / all;
  return between(Pose::of(before.pos), Pose::of(after.pos), part).position();
}

}  // namespace

OdometryData interpolated(const OdometryData& before, const OdometryData& after, TimeStamp time) {
  return {.recordingTime = time, .pos = pose_at(before, after, time)};
}

PositionData interpolated(const PositionData& before, const PositionData& after, TimeStamp time) {
  const auto larger = [&](auto Position3d::*side) {
    return std::max(before.var.*side, after.var.*side);
  };
  return {.recordingTime = time,
          .pos = pose_at(before, after, time),
          .var = {larger(&Position3d::x), larger(&Position3d::y), larger(&Position3d::z),
                  larger(&Position3d::phi), larger(&Position3d::psi), larger(&Position3d::rho)}};
}

void PositionTracker::begin(const Drift& drift, std::chrono::milliseconds blending,
                            const OdometryData& odometry) {
  drift_ = drift;
  blending_ = blending;
  blends_ = false;
  frame_ = {reported_, Pose::of(odometry.pos)};
  newest_ = odometry;
  followed_ = true;
}

void PositionTracker::expect(double deviation) {
  if (is_updated_) return;
  constexpr double kTurnPerMm = radians(0.03);
  deviation_ = {deviation, deviation, std::min(kPi, deviation * kTurnPerMm)};
}

PositionData PositionTracker::follow(const OdometryData& odometry) {
  const Pose now = Pose::of(odometry.pos);
  if (followed_) grow(Pose::of(newest_.pos), now);
  followed_ = true;
  newest_ = odometry;

  Pose pose = frame_.at(now);
  const auto since = odometry.recordingTime - updated_;
  blends_ = blends_ && since < blending_;
  if (blends_) {
    const double part = std::max(0.0, std::chrono::duration<double>(since) / blending_);
    pose = between(earlier_.at(now), pose, part);
  }
  reported_ = pose;
  Position3d deviation = known_deviation_;
  deviation.x = whole_millimetres(deviation_.x);
  deviation.y = whole_millimetres(deviation_.y);
  deviation.rho = static_cast<f32>(deviation_.rho);
  return {.recordingTime = odometry.recordingTime, .pos = pose.position(), .var = deviation};
}

void PositionTracker::update(const PositionData& known, const OdometryData& then) {
  if (blending_.count() > 0 && followed_) {
    // The blending starts at the current result, also during an earlier blending.
    const Pose now = Pose::of(newest_.pos);
    earlier_ = {Pose::of(follow(newest_).pos), now};
    blends_ = true;
    updated_ = newest_.recordingTime;
  }
  is_updated_ = true;
  frame_ = {Pose::of(known.pos), Pose::of(then.pos)};
  known_deviation_ = known.var;
  deviation_ = {static_cast<double>(known.var.x), static_cast<double>(known.var.y), known.var.rho};
  if (followed_) grow(Pose::of(then.pos), Pose::of(newest_.pos));
}

void PositionTracker::grow(const Pose& from, const Pose& to) {
  const double dx = std::abs(to.x - from.x);
  const double dy = std::abs(to.y - from.y);
  deviation_.x += drift_.x * dx / 1000 + drift_.y * dy / 5000;
  deviation_.y += drift_.y * dy / 1000 + drift_.x * dx / 5000;
  deviation_.rho += 0.1 * std::abs(signed_angle(to.rho - from.rho)) + (dx + dy) / 100000;
}

}  // namespace rack::navigation
