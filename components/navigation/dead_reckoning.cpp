#include "components/navigation/dead_reckoning.h"

#include <cmath>

namespace rack::navigation {

OdometryData DeadReckoning::add(const ChassisData& movement) {
  const Pose step{.x = movement.deltaX, .y = movement.deltaY, .rho = movement.deltaRho};
  if (std::isfinite(step.x) && std::isfinite(step.y) && std::isfinite(step.rho))
    pose_ = pose_ + step;
  return {.recordingTime = movement.recordingTime, .pos = pose_.position()};
}

OdometryData interpolated(const OdometryData& before, const OdometryData& after, TimeStamp time) {
  const double all = static_cast<double>((after.recordingTime - before.recordingTime).count());
  const double part =
      all == 0 ? 0 : static_cast<double>((time - before.recordingTime).count()) / all;
  return {.recordingTime = time,
          .pos = between(Pose::of(before.pos), Pose::of(after.pos), part).position()};
}

}  // namespace rack::navigation
