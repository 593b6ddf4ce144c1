#include "components/pilot/obstacle_stop.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "components/pilot/drive.h"

namespace rack::pilot {

namespace {

constexpr double kCrawls = 10;  // mm/s: lower speeds count as 0
constexpr double kFarAway = 1e9;
constexpr double kStraightAhead = 1e-7;  // 1/mm
constexpr int kWhileHolding = 2;
constexpr double kTolerated = 0.25;    // of the safety margin
constexpr double kPassesSlowly = 100;  // mm/s

// The part of the path up to the next change between forward and backward, where the vehicle stops.
std::span<const PolarSpline> same_sense(std::span<const PolarSpline> path) {
  std::size_t count = 1;
  while (count < path.size() && path::sense(path[count]) == path::sense(path[0])) ++count;
  return path.first(count);
}

// As text with two decimals.
std::string hundredths(double value) {
  const auto whole = std::lround(value * 100);
  return std::to_string(whole / 100) + "." + std::to_string(100 + whole % 100).substr(1);
}

}  // namespace

tims::Result<void> check_braking(const ChassisParamData& chassis, double speed_max,
                                 std::chrono::milliseconds reaction) {
  const auto refuse = [](std::string text) {
    return tims::Error(tims::Errc::kInvalidArgument, std::move(text));
  };
  if (chassis.decMax <= 0) return refuse("the chassis reports decMax 0: it cannot brake");
  const double needed = seconds(reaction) + speed_max / (2.0 * chassis.decMax);
  if (chassis.breakConstant >= needed) return {};
  const double slow = 2.0 * chassis.decMax * (chassis.breakConstant - seconds(reaction));
  return refuse("with breakConstant " + hundredths(chassis.breakConstant) +
                " the vehicle would brake too late at " + std::to_string(std::lround(speed_max)) +
                " mm/s: decMax " + std::to_string(chassis.decMax.raw()) + " and " +
                std::to_string(reaction.count()) + " ms of reaction time need " +
                hundredths(std::ceil(needed * 100) / 100) +
                "; set this breakConstant at the chassis, or limit maxSpeed of the pilot to " +
                std::to_string(std::max(0L, static_cast<long>(slow))) + " mm/s");
}

ObstacleStop::ObstacleStop(const ChassisParamData& chassis, std::chrono::milliseconds reaction)
    : chassis_(chassis), margins_(chassis), reaction_(seconds(reaction)) {
  const double fast = chassis.vxMax;
  const double brakes = fast * reaction_ + fast * fast / (2 * std::max(1.0, 1.0 * chassis.decMax));
  look_ahead_ = 1000 + kMoving * std::max(brakes, fast * chassis.breakConstant);
}

// The solution of v t + v^2 / 2a = free for v.
double ObstacleStop::still_stops(double free) const {
  if (free <= 0) return 0;
  const double rate = std::max(1.0, 1.0 * chassis_.decMax);
  const double delay = rate * reaction_;
  return std::sqrt(delay * delay + 2 * rate * free) - delay;
}

double ObstacleStop::hull_ahead() const {
  return sense_ > 0 ? chassis_.boundaryFront : chassis_.boundaryBack;
}

// Distance of a point, in the frame of the vehicle, to its hull.
double ObstacleStop::clearance(const Pose& point) const {
  const double x = std::max(
      {0.0, point.x - chassis_.boundaryFront.raw(), -point.x - chassis_.boundaryBack.raw()});
  const double y = std::max(
      {0.0, point.y - chassis_.boundaryRight.raw(), -point.y - chassis_.boundaryLeft.raw()});
  return std::hypot(x, y);
}

bool ObstacleStop::may_turn(const Scan2dData& scan, const Pose& seen_from, const Pose& at,
                            double omega) const {
  constexpr double kTurnAhead = radians(20.0);
  constexpr int kTurnSteps = 4;
  for (const ScanPoint& point : scan.points) {
    if (!counts(point)) continue;
    const Pose here = seen_from + Pose{.x = 1.0 * point.x, .y = 1.0 * point.y};
    const double now = clearance(here - at);
    const double margin = chassis_.safetyMargin;
    const double least = now < margin ? kTurnMargin : margin;
    for (int i = 1; i <= kTurnSteps; ++i) {
      const double turn = std::copysign(kTurnAhead * i / kTurnSteps, omega);
      const double then = clearance(here - (at + Pose{.rho = turn}));
      if (then < least && then < now) return false;
    }
  }
  return true;
}

// Converts a point to the frame of a vehicle on a straight path; false: it is out of reach.
bool ObstacleStop::straighten(const ScanPoint& point, const Pose& seen_from, const Course& course,
                              ScanPoint& straight) const {
  const Pose at =
      seen_from + Pose{.x = static_cast<double>(point.x), .y = static_cast<double>(point.y)};
  double before = -course.from;
  double nearest = kFarAway;
  for (std::size_t i = 0; i < course.splines.size() && before < look_ahead_; ++i) {
    const PolarSpline& spline = course.splines[i];
    const path::Beside seen = path::beside(spline, at);
    const double along = path::sense(spline) * seen.along;
    const bool first = i == 0;
    const bool last = i + 1 == course.splines.size();
    const double ahead = before + along;
    before += path::size(spline);
    if ((along < 0 && !first) || (along > path::size(spline) && !last)) continue;
    // Both ends of the vehicle swing out in a bend.
    const double radius = std::abs(static_cast<double>(spline.radius));
    const double longest = std::max(chassis_.boundaryFront, chassis_.boundaryBack);
    const double swing = radius > 0 ? longest * longest / (2 * radius) : 0;
    const double across = sense_ * seen.across;
    const bool bends_right = sense_ * spline.radius > 0;
    const double wider_right = course.right + (bends_right ? 0 : swing);
    const double wider_left = course.left + (bends_right ? swing : 0);
    const double narrow =
        across > 0 ? std::max(0.0, across - wider_right) : std::min(0.0, across + wider_left);
    const double distance = std::max(ahead, kLateral * std::abs(narrow));
    if (distance >= nearest || ahead > look_ahead_) continue;
    nearest = distance;
    straight = point;
    straight.x = whole_millimetres(ahead);
    straight.y = whole_millimetres(narrow);
  }
  return nearest < kFarAway;
}

// The box of drive.h, around a vehicle that drives forward along the straightened path.
double ObstacleStop::limit(const Scan2dData& scan, const Pose& seen_from, const Course& course,
                           bool comfort) {
  const double margin = margins_.safetyMargin;
  const double ahead = hull_ahead() + margin;
  const double right = margin + (sense_ > 0 ? margins_.boundaryRight : margins_.boundaryLeft);
  const double left = margin + (sense_ > 0 ? margins_.boundaryLeft : margins_.boundaryRight);
  const double behind = sense_ > 0 ? margins_.boundaryBack : margins_.boundaryFront;
  const double constant = std::max<double>(chassis_.breakConstant, 1e-3);
  double speed = kFarAway;
  for (const ScanPoint& point : scan.points) {
    ScanPoint straight;
    if (!counts(point) || !straighten(point, seen_from, course, straight)) continue;
    const double x = straight.x;
    const double y = straight.y;
    if (x < -behind) continue;
    const bool moves = (point.type & scan_point::kClassMask) == kDynamicObstacle;
    const double earlier = moves ? kMoving : 1;
    const double lateral = std::max({0.0, y - right, -y - left});
    const double free = std::max(0.0, x - ahead);
    // Beside the path, or a little within the margin: noise, or a path with hardly more room.
    const double within = std::min(right - y, y + left);
    const bool is_aside = !moves && within < kTolerated * margin;
    const double slowest = is_aside ? kPassesSlowly : 0;
    if (lateral <= 0) {
      speed = std::min(speed, std::max(slowest, still_stops(free) / earlier));
      if (comfort && !is_aside) free_distance_ = std::min(free_distance_, free);
    }
    if (!comfort) continue;
    // Beyond the end of the path, only points that the hull would touch there count.
    if (x - ahead >= course.end) continue;
    const double remaining = std::max(0.0, free - margins_.safetyMarginMove);
    const double comfortable = std::max(remaining, kLateral * lateral) / (constant * earlier);
    speed = std::min(speed, std::max(slowest, comfortable));
  }
  return speed;
}

double ObstacleStop::speed_max(const Scan2dData& scan, const Pose& seen_from, const Pose& at,
                               const PathFollower& follower) {
  free_distance_ = look_ahead_;
  margins_ = chassis_;
  if (follower.holds()) {
    margins_.safetyMargin = kWhileHolding * chassis_.safetyMargin;
    margins_.safetyMarginMove = kWhileHolding * chassis_.safetyMarginMove;
  }
  const auto path = follower.path();
  if (path.empty()) return 0;
  const PolarSpline& spline = path[follower.index()];
  sense_ = path::sense(spline) * (follower.reverts() ? -1 : 1);

  // The current arc.
  const PathFollower::Command now = follower.last();
  const double curve = std::abs(now.speed) < 1 ? 0 : now.omega / now.speed;
  const PolarSpline arc =
      std::abs(curve) < kStraightAhead
          ? path::line(at, sense_ * look_ahead_)
          : path::arc(at, whole_millimetres(std::clamp(1 / curve, -1e7, 1e7)),
                      sense_ * std::min(look_ahead_, 0.75 * kPi / std::abs(curve)));
  double speed = limit(scan, seen_from, {{&arc, 1}, 0, 0, 0, kFarAway}, follower.reverts());
  if (follower.reverts()) return speed < kCrawls ? 0 : speed;

  const path::Beside beside = path::beside(spline, at);
  const double across = sense_ * beside.across;
  const double turned = hull_ahead() * std::sin(beside.turned);
  const auto ahead = same_sense(path.subspan(follower.index()));
  const double from = path::sense(spline) * beside.along;
  double end = -from;
  for (const PolarSpline& part : ahead) end += path::size(part);
  const Course course{ahead, from, std::max(0.0, -across) + std::max(0.0, -turned),
                      std::max(0.0, across) + std::max(0.0, turned), end};
  speed = std::min(speed, limit(scan, seen_from, course, true));
  return speed < kCrawls ? 0 : speed;
}

}  // namespace rack::pilot
