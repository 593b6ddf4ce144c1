#include "components/pilot/lab_course.h"

#include <algorithm>
#include <cmath>

namespace rack::pilot {

namespace {

constexpr double kLabCourseThere = 50;      // mm
constexpr double kLabCourseAligned = 0.03;  // rad
constexpr double kLeftBehind = 1.2;         // rad: the destination is beside or behind the vehicle
constexpr i32 kDirectionOnly = 10;          // mm/s; smaller values only select forward or backward

}  // namespace

LabCourse::LabCourse(const LabCourseSettings& settings, const ChassisParamData& chassis)
    : settings_(settings), chassis_(chassis) {
  settings_.speed_max = std::min(settings.speed_max, chassis.vxMax.raw());
  settings_.side_speed_max = std::min(settings.side_speed_max, chassis.vyMax.raw());
  settings_.omega_max = std::min<double>(settings.omega_max, chassis.omegaMax);
  chassis_.safetyMarginMove = std::max(chassis.safetyMarginMove.raw(), settings.obstacle_distance);
}

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
  const double most = std::max(settings_.omega_max, 0.0);
  const double omega = std::clamp(chassis_.pilotParameterB * missing, -most, most);
  return {.omega = static_cast<f32>(omega)};
}

Drive LabCourse::drive(double left, double missing, const Scan2dData& scan) const {
  const double target = destination_.speed >= kDirectionOnly
                            ? std::min(destination_.speed.raw(), settings_.speed_max)
                            : settings_.speed_max;
  const double slowed =
      std::max(target * left / settings_.slow_distance, static_cast<double>(chassis_.vxMin));
  const double speed = std::min(target, slowed);
  Drive drive = turn(missing);
  if (settings_.side_speed_max > 0) {
    const double aside = speed * std::sin(missing);
    const Direction across = aside < 0 ? Direction::kLeft : Direction::kRight;
    const double safe = std::min(safe_speed(across, chassis_, scan), settings_.side_speed_max);
    drive.side = static_cast<i32>(std::clamp(aside, -safe, safe));
  }
  const double safe = safe_speed(Direction::kForward, chassis_, scan);
  drive.speed = static_cast<i32>(std::min(speed, safe));
  return drive;
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
      if (std::abs(missing) > settings_.heading_error) return turn(missing);
      state_ = State::kDrive;
      return {};
    case State::kDrive: {
      if (left < kLabCourseThere ||
          std::abs(missing) > std::max(kLeftBehind, settings_.heading_error)) {
        state_ = left < kLabCourseThere ? State::kTurnAsItShallStand : State::kTurnThere;
        return {};
      }
      return drive(left, missing, scan);
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
