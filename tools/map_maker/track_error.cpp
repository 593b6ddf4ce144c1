#include "tools/map_maker/track_error.h"

#include <cmath>

namespace rack::map_maker {

namespace {

// What has to be put before the track so that it lies on the true poses.
Pose frame_of(std::span<const Pose> laser, const mcl_eval::Truth& truth) {
  Pose is;
  Pose should;
  const auto count = static_cast<double>(truth.poses.size());
  for (const mcl_eval::TruePose& pose : truth.poses) {
    is.x += laser[pose.scan].x / count;
    is.y += laser[pose.scan].y / count;
    should.x += pose.laser.x / count;
    should.y += pose.laser.y / count;
  }
  double along = 0;
  double across = 0;
  for (const mcl_eval::TruePose& pose : truth.poses) {
    const double ix = laser[pose.scan].x - is.x;
    const double iy = laser[pose.scan].y - is.y;
    const double sx = pose.laser.x - should.x;
    const double sy = pose.laser.y - should.y;
    along += ix * sx + iy * sy;
    across += ix * sy - iy * sx;
  }
  const Pose turn{.rho = std::atan2(across, along)};
  const Pose middle = turn + is;
  return {.x = should.x - middle.x, .y = should.y - middle.y, .rho = turn.rho};
}

}  // namespace

TrackError track_error(std::span<const Pose> laser, const mcl_eval::Truth& truth) {
  TrackError error;
  const auto add = [&](const Pose& off) {
    error.metres.push_back(std::hypot(off.x, off.y) / 1000);
    error.degrees.push_back(degrees(std::abs(signed_angle(off.rho))));
  };
  if (!truth.poses.empty()) {
    const Pose frame = frame_of(laser, truth);
    for (const mcl_eval::TruePose& pose : truth.poses) add((frame + laser[pose.scan]) - pose.laser);
  }
  for (const mcl_eval::Relation& relation : truth.relations)
    add((laser[relation.to] - laser[relation.from]) - relation.step);
  return error;
}

}  // namespace rack::map_maker
