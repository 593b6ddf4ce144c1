#include "components/pilot/lab_course.h"

#include <algorithm>
#include <cmath>

namespace rack::pilot {

namespace {

constexpr double kLabCourseThere = 50;      // mm
constexpr double kLabCourseAligned = 0.03;  // rad
constexpr double kLeftBehind = 1.2;         // rad: the destination is beside or behind the vehicle
constexpr double kSlowsDown = 1;            // mm of distance left per mm/s
constexpr i32 kDirectionOnly = 10;          // mm/s; smaller values only select forward or backward

}  // namespace

void LabCourse::set_destination(const PilotDestData& destination) {
  destination_ = destination;
  sent_ = true;
  state_ = State::kTurnThere;
}

double LabCourse::distance(const Pose& at) const {
  if (!sent_) return -1;
  if (state_ == State::kIdle) return 0;
  return std::hypot(destination_.pos.x - at.x, destination_.pos.y - at.y);
}

Drive LabCourse::turn(double missing) const {
  const double most = chassis_.omegaMax;
  const double omega = std::clamp(chassis_.pilotParameterB * missing, -most, most);
  return {.omega = static_cast<f32>(omega)};
}

Drive LabCourse::go(const Pose& at, const Scan2dData& scan) {
  const double x = destination_.pos.x - at.x;
  const double y = destination_.pos.y - at.y;
  const double left = std::hypot(x, y);
  const double missing = signed_angle(std::atan2(y, x) - at.rho);
  switch (state_) {
    case State::kIdle:
      return {};
    case State::kTurnThere:
      if (left < kLabCourseThere) {
        state_ = State::kTurnAsItShallStand;
        return {};
      }
      if (std::abs(missing) > kLabCourseAligned) return turn(missing);
      state_ = State::kDrive;
      return {};
    case State::kDrive: {
      if (left < kLabCourseThere || std::abs(missing) > kLeftBehind) {
        state_ = left < kLabCourseThere ? State::kTurnAsItShallStand : State::kTurnThere;
        return {};
      }
      const double target = destination_.speed >= kDirectionOnly
                                ? static_cast<double>(destination_.speed)
                                : static_cast<double>(chassis_.vxMax);
      const double safe = safe_speed(Direction::kForward, chassis_, scan);
      const double speed = std::min({target, safe, left / kSlowsDown});
      Drive drive = turn(missing);
      drive.speed = static_cast<i32>(speed);
      return drive;
    }
    case State::kTurnAsItShallStand: {
      const double rest = signed_angle(static_cast<double>(destination_.pos.rho) - at.rho);
      if (std::abs(rest) > kLabCourseAligned) return turn(rest);
      state_ = State::kIdle;
      return {};
    }
  }
  return {};
}

}  // namespace rack::pilot
