#include "components/pilot/wall_follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/geometry/pose.h"

namespace rack::pilot {
namespace {

constexpr i64 kAcceleration = 100;         // mm/s2
constexpr double kApproach = radians(30);  // maximum angle to a wall that is too far or too near
constexpr double kRoomAfterTurning = 1.5;  // factor on the free distance required for driving

// In safety margins around the hull: starting a turn requires more room than continuing it.
constexpr int kMarginsToBegin = 2;
constexpr int kMarginsToGoOn = 1;

bool valid(const ScanPoint& point) { return (point.type & scan_point::kInvalid) == 0; }

// Whether a point is in the area: x from..to, y from..to, mm.
struct Area {
  double back, front, left, right;
};
bool is_free(const Scan2dData& scan, const Area& area) {
  return std::ranges::none_of(scan.points, [&](const ScanPoint& point) {
    const double x = point.x;
    const double y = point.y;
    return valid(point) && (point.type & scan_point::kClassMask) != kLandmark && x >= area.back &&
           x <= area.front && y >= area.left && y <= area.right;
  });
}

struct Seen {
  double range;    // mm
  double bearing;  // rad
};
template <typename Wanted>
std::optional<Seen> nearest(const Scan2dData& scan, Wanted wanted) {
  const ScanPoint* found = nullptr;
  for (const ScanPoint& point : scan.points) {
    if (valid(point) && wanted(point) && (found == nullptr || point.z < found->z)) found = &point;
  }
  if (found == nullptr) return std::nullopt;
  return Seen{static_cast<double>(found->z),
              std::atan2(static_cast<double>(found->y), static_cast<double>(found->x))};
}
std::optional<Seen> nearest(const Scan2dData& scan) {
  return nearest(scan, [](const ScanPoint&) { return true; });
}

// Clockwise angle until a point at this bearing is at a right angle to the right, or to the left.
double angle_to_the_right(double bearing) { return signed_angle(bearing - kPi / 2); }
double angle_to_the_left(double bearing) { return signed_angle(bearing + kPi / 2); }

}  // namespace

Drive WallFollower::follow(const Scan2dData& scan, std::chrono::milliseconds period,
                           double heading) {
  const i64 faster = kAcceleration * period.count() / 1000;
  speed_ = static_cast<i32>(std::min<i64>(speed_ + faster, settings_.speed_max));
  Drive result = turns() ? turn(scan, heading) : drive(scan);
  result.target = settings_.speed_max;
  result.speed_safe = safe_straight(scan);
  return result;
}

Drive WallFollower::drive(const Scan2dData& scan) {
  return settings_.mode == WallFollowerSettings::Mode::kGeometric ? geometric(scan)
                                                                  : braitenberg(scan);
}

// --- modes

Drive WallFollower::geometric(const Scan2dData& scan) {
  const auto anything = nearest(scan);
  if (!anything) return go(0, scan);
  const auto wall = nearest(scan, [](const ScanPoint& point) { return point.y >= 0; });
  if (!wall) return stop_and_turn(angle_to_the_right(anything->bearing));
  const double angle = angle_to_the_right(wall->bearing);
  return go(chassis_.pilotParameterB * (angle + lateral(wall->range)), scan);
}

Drive WallFollower::braitenberg(const Scan2dData& scan) {
  if (!free_ahead(scan, settings_.test_distance)) return stop_and_turn();
  if (chooses_ || !keeps_wall(scan)) choose_wall(scan);
  return go(clamp_omega(steer_along_wall(scan)), scan);
}

void WallFollower::choose_wall(const Scan2dData& scan) {
  wall_ = Wall::kNone;
  chooses_ = false;
  const auto anything = nearest(scan);
  if (!anything) return;
  const i32 back = -chassis_.boundaryBack;
  const auto is_near = [this](const std::optional<Seen>& seen) {
    return seen && seen->range <= settings_.distance;
  };
  const bool right =
      is_near(nearest(scan, [=](const ScanPoint& p) { return p.x >= back && p.y > 0; }));
  const bool left =
      is_near(nearest(scan, [=](const ScanPoint& p) { return p.x >= back && p.y < 0; }));
  if (right && left) {
    wall_ = Wall::kBoth;
  } else if (right || left) {
    wall_ = right ? Wall::kRight : Wall::kLeft;
  } else {
    wall_ = anything->bearing >= 0 ? Wall::kRight : Wall::kLeft;
  }
}

// True while no other wall is nearer.
bool WallFollower::keeps_wall(const Scan2dData& scan) const {
  const i32 back = -chassis_.boundaryBack;
  const auto right = nearest(
      scan, [&](const ScanPoint& p) { return p.y > 0 && (wall_ == Wall::kRight || p.x >= back); });
  const auto left = nearest(
      scan, [&](const ScanPoint& p) { return p.y < 0 && (wall_ == Wall::kLeft || p.x >= back); });
  const auto alone = [this](const std::optional<Seen>& own, const std::optional<Seen>& other) {
    if (!own) return false;
    return !other || (other->range >= own->range && other->range > settings_.distance);
  };
  switch (wall_) {
    case Wall::kNone:
      return false;
    case Wall::kRight:
      return alone(right, left);
    case Wall::kLeft:
      return alone(left, right);
    case Wall::kBoth:
      break;
  }
  return right && left && right->range <= settings_.distance && left->range <= settings_.distance;
}

// rad/s
double WallFollower::steer_along_wall(const Scan2dData& scan) const {
  const i32 back = wall_ == Wall::kBoth ? -chassis_.boundaryBack : std::numeric_limits<i32>::min();
  double angle = 0;
  double offset = 0;
  double walls = 0;
  if (wall_ == Wall::kRight || wall_ == Wall::kBoth) {
    const auto right = nearest(scan, [=](const ScanPoint& p) { return p.x >= back && p.y > 0; });
    if (right) {
      angle += angle_to_the_right(right->bearing);
      offset += right->range - settings_.distance;
      ++walls;
    }
  }
  if (wall_ == Wall::kLeft || wall_ == Wall::kBoth) {
    const auto left = nearest(scan, [=](const ScanPoint& p) { return p.x >= back && p.y < 0; });
    if (left) {
      angle += angle_to_the_left(left->bearing);
      offset -= left->range - settings_.distance;
      ++walls;
    }
  }
  if (walls == 0) return 0;
  return chassis_.pilotParameterB * (angle / walls + lateral(settings_.distance + offset / walls));
}

// --- driving

// With that angular speed, limited by the turning radius.
Drive WallFollower::go(double omega, const Scan2dData& scan) {
  const double tightest = 1.0 / std::max(chassis_.minTurningRadius.raw(), 1);
  const double curve = speed_ == 0 ? 0 : std::clamp(omega / speed_, -tightest, tightest);
  const double safe = std::min<double>(safe_speed(Direction::kForward, chassis_, scan),
                                       speed_for_curve(curve, chassis_));
  speed_ = std::min(speed_, static_cast<i32>(safe));
  if (speed_ <= 0) return stop_and_turn();
  speed_ = std::max(speed_, chassis_.vxMin.raw());
  return {.speed = speed_, .omega = static_cast<f32>(curve * speed_)};
}

Drive WallFollower::stop_and_turn(std::optional<double> angle) {
  task_ = Task::kTurn;
  turn_.reset();
  turn_wanted_ = angle;
  speed_ = 0;
  return {};
}

Drive WallFollower::turn(const Scan2dData& scan, double heading) {
  speed_ = 0;
  if (!turn_ && !begin_turn(scan, heading)) return {};
  turn_->done += signed_angle(heading - turn_->heading);
  turn_->heading = heading;
  const bool done = std::abs(turn_->done) >= std::abs(turn_->angle) &&
                    std::signbit(turn_->done) == std::signbit(turn_->angle);
  const bool room = settings_.mode == WallFollowerSettings::Mode::kBraitenberg &&
                    free_ahead(scan, kRoomAfterTurning * settings_.test_distance);
  if (done || room) {
    task_ = Task::kDrive;
    chooses_ = true;
    return {};
  }
  if (!free_to_turn(scan, turn_->angle, kMarginsToGoOn)) {
    turn_.reset();
    return {};
  }
  return {.omega = static_cast<f32>(clamp_omega(std::copysign(settings_.omega_max, turn_->angle)))};
}

// False: there is no room for the turn; the vehicle waits.
bool WallFollower::begin_turn(const Scan2dData& scan, double heading) {
  double angle = turn_wanted_ ? *turn_wanted_ : angle_of_turn(scan);
  if (!free_to_turn(scan, angle, kMarginsToBegin)) {
    angle -= std::copysign(2 * kPi, angle);
    if (!free_to_turn(scan, angle, kMarginsToBegin)) {
      if (safe_straight(scan) > 0) task_ = Task::kDrive;
      return false;
    }
  }
  turn_ = Turn{.angle = angle, .heading = heading};
  return true;
}

// The angle of a turn in front of a wall.
double WallFollower::angle_of_turn(const Scan2dData& scan) {
  const i32 front = chassis_.boundaryFront;
  const auto ahead = nearest(scan, [=](const ScanPoint& p) { return p.x > front; });
  if (settings_.mode == WallFollowerSettings::Mode::kGeometric)
    return ahead ? angle_to_the_right(ahead->bearing) : -kPi / 2;
  // Away from the wall that was followed, even if the direction is not free yet.
  if (wall_ == Wall::kRight) return -kPi / 2;
  if (wall_ == Wall::kLeft) return kPi / 2;
  const bool to_the_left = !ahead || ahead->bearing >= 0;
  wall_ = to_the_left ? Wall::kRight : Wall::kLeft;
  if (!ahead) return -kPi / 2;
  return to_the_left ? angle_to_the_right(ahead->bearing) : angle_to_the_left(ahead->bearing);
}

// --- evaluation of the scan

// Angle of approach, rad; positive towards a wall on the right that is too far away.
double WallFollower::lateral(double range) const {
  return std::clamp(chassis_.pilotParameterA * (range - settings_.distance), -kApproach, kApproach);
}

double WallFollower::clamp_omega(double omega) const {
  const double limit = std::min<double>(settings_.omega_max, chassis_.omegaMax);
  return std::clamp(omega, -limit, limit);
}

// Safe speed straight ahead, mm/s.
i32 WallFollower::safe_straight(const Scan2dData& scan) const {
  ChassisParamData front_only = chassis_;
  front_only.boundaryBack = 0;
  return std::min(safe_speed(Direction::kForward, front_only, scan), settings_.speed_max);
}

bool WallFollower::free_ahead(const Scan2dData& scan, double distance) const {
  const double margin = chassis_.safetyMargin;
  const double front = chassis_.boundaryFront;
  return safe_straight(scan) > 0 &&
         is_free(scan, {front, front + distance, -margin - chassis_.boundaryLeft.raw(),
                        margin + chassis_.boundaryRight.raw()});
}

// During a turn the front needs more room on one side and the rear on the other.
bool WallFollower::free_to_turn(const Scan2dData& scan, double angle, int margins) const {
  const double margin = 1.0 * margins * chassis_.safetyMargin;
  const double left = -1.0 * chassis_.boundaryLeft.raw();
  const double right = chassis_.boundaryRight;
  const double front = chassis_.boundaryFront + margin;
  const double back = -1.0 * chassis_.boundaryBack.raw() - margin;
  const double front_right = angle > 0 ? right + margin : right;
  const double front_left = angle > 0 ? left : left - margin;
  const double back_right = angle > 0 ? right : right + margin;
  const double back_left = angle > 0 ? left - margin : left;
  return is_free(scan, {0, front, front_left, front_right}) &&
         is_free(scan, {back, 0, back_left, back_right});
}

}  // namespace rack::pilot
