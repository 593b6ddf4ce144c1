#include "components/pilot/wall_follower.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "components/geometry/angle.h"

namespace rack::pilot {
namespace {

constexpr double kAcceleration = 200;  // mm/s2: gently
constexpr double kHeadingGain = 1.0;   // rad/s for each rad
constexpr double kApproach = kPi / 3;  // steepest angle to a wall that is too far or too near

struct Polar {
  double range;
  double bearing;
};

std::optional<Polar> polar(const ScanPoint& point) {
  if ((point.type & scan_point::kInvalid) != 0) return std::nullopt;
  const double x = point.x;
  const double y = point.y;
  return Polar{std::hypot(x, y), std::atan2(y, x)};
}

bool within(double bearing, double from_degrees, double to_degrees) {
  return bearing >= radians(from_degrees) && bearing <= radians(to_degrees);
}

}  // namespace

Drive WallFollower::follow(const Scan2dData& scan, std::chrono::milliseconds period) {
  const i32 safe = std::min(safe_speed(Direction::kForward, chassis_, scan), settings_.speed_max);
  const double omega_max = std::min<double>(settings_.omega_max, chassis_.omegaMax);
  if (blocked(scan, safe)) {
    speed_ = 0;
    return {.speed = 0, .speed_max = safe, .omega = static_cast<f32>(omega_max)};
  }
  const Wish wish = settings_.mode == WallFollowerSettings::Mode::kGeometric ? geometric(scan)
                                                                             : braitenberg(scan);
  const double faster = kAcceleration * std::chrono::duration<double>(period).count();
  speed_ = std::min({wish.speed * settings_.speed_max, static_cast<double>(safe), speed_ + faster});
  return {.speed = static_cast<i32>(speed_),
          .speed_max = safe,
          .omega = static_cast<f32>(std::clamp(wish.omega, -omega_max, omega_max))};
}

// Once it has stopped it turns until there is room, not just until the next step fits.
bool WallFollower::blocked(const Scan2dData& scan, i32 safe) {
  if (safe == 0) turning_ = true;
  if (!turning_) return false;
  const double room = chassis_.boundaryFront + settings_.test_distance;
  const double side = chassis_.boundaryRight + chassis_.safetyMargin;
  const bool free = std::ranges::none_of(scan.points, [&](const ScanPoint& point) {
    const double x = point.x;
    const double y = point.y;
    return polar(point) && x > 0 && x < room && std::abs(y) < side;
  });
  turning_ = safe == 0 || !free;
  return turning_;
}

// Towards the left of the nearest wall there is: along it, and a little to it or away from it.
WallFollower::Wish WallFollower::geometric(const Scan2dData& scan) const {
  std::optional<Polar> wall;
  for (const ScanPoint& point : scan.points) {
    const auto seen = polar(point);
    if (seen && within(seen->bearing, -150, 20) && (!wall || seen->range < wall->range))
      wall = seen;
  }
  if (!wall) return {.speed = 1};
  const double too_far = (wall->range - settings_.distance) / settings_.test_distance;
  const double turn = wall->bearing + kPi / 2 - std::clamp(too_far, -1.0, 1.0) * kApproach;
  return {.speed = std::max(0.0, std::cos(turn)), .omega = kHeadingGain * turn};
}

// Two eyes, each of which drives the wheel on its own side.
WallFollower::Wish WallFollower::braitenberg(const Scan2dData& scan) const {
  double left = 0;
  double right = 0;
  double ahead = 0;
  for (const ScanPoint& point : scan.points) {
    const auto seen = polar(point);
    if (!seen) continue;
    const double near = std::clamp(
        1 - (seen->range - settings_.distance / 2.0) / settings_.test_distance, 0.0, 1.0);
    if (within(seen->bearing, -100, 0)) left = std::max(left, near);
    if (within(seen->bearing, 0, 100)) right = std::max(right, near);
    if (within(seen->bearing, -35, 35)) ahead = std::max(ahead, near);
  }
  return {.speed = 1 - ahead,
          .omega = settings_.omega_max * (left - right + (left >= right ? ahead : -ahead))};
}

}  // namespace rack::pilot
