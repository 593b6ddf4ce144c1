#include "components/position/reckoning.h"

#include <algorithm>
#include <cmath>

namespace rack::navigation {

OdometryData DeadReckoning::add(const ChassisData& movement) {
  const Pose step{.x = movement.deltaX, .y = movement.deltaY, .rho = movement.deltaRho};
  if (std::isfinite(step.x) && std::isfinite(step.y) && std::isfinite(step.rho))
    pose_ = pose_ + step;
  return {.recordingTime = movement.recordingTime, .pos = pose_.position()};
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
