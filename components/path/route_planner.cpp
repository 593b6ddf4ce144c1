#include "components/path/route_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "components/path/rddf.h"
#include "components/path/vehicle.h"

namespace rack::path {
namespace {

constexpr int kPosesAPeriod = 1500;    // poses that a search expands per period
constexpr double kDirectionOnly = 10;  // mm/s, as in waypoints
constexpr std::array<double, 5> kBehind = {2000, 4000, 7000, 12000,
                                           20000};  // distances behind an obstacle, mm

// Java programs write the bits of a float (1 or -1) into this integer field.
double direction_or_speed(i32 field) {
  constexpr i32 kMinusOne = static_cast<i32>(0xBF800000);
  constexpr i32 kOne = 0x3F800000;
  if (field == kMinusOne) return -1;
  if (field == kOne) return 1;
  return field;
}

double length_of(std::span<const PolarSpline> path) {
  double length = 0;
  for (const PolarSpline& spline : path) length += size(spline);
  return length;
}

tims::Error not_now(std::string why) { return {tims::Errc::kInvalidArgument, std::move(why)}; }

}  // namespace

RoutePlanner::RoutePlanner() {
  path_.reserve(kSplinesMax);
  before_.reserve(kSplinesMax);
  waypoints_.reserve(kWaypointsMax);
}

Result<void> RoutePlanner::begin(const RouteSettings& settings, PlanningMap map) {
  located_ = planning_ = false;
  seen_.begin();
  room_.begin(settings.chassis);
  settings_ = settings;
  limits_ = settings.limits;
  planner_.emplace(PlanSettings{limits_, hull_of(settings.chassis), settings.comfort});
  map_ = std::move(map);
  space_ = map_.space;
  return check(limits_);
}

Result<void> RoutePlanner::begin_route() {
  must_replan_ = destination_.has_value();
  leads_there_ = false;
  return must_replan_ ? Result<void>() : make_route();
}

// --- one period

void RoutePlanner::take_position(const Pose& robot) {
  robot_ = robot;
  located_ = true;
  room_.follow(robot);
}

void RoutePlanner::take_scan(const Scan2dData& scan) { seen_.take(scan, robot_); }

std::optional<std::string> RoutePlanner::step(TimeStamp now, PathData& data) {
  std::optional<std::string> failure;
  if (must_replan_ && located_) {
    must_replan_ = false;
    if (auto good = plan_destination(); !good) {
      failure = good.error().message();
      take({});
    }
  }
  if (planning_) failure = go_on_planning();
  if (room_.is_active() && !planning_) go_on_aside(now);
  if (!std::exchange(is_new_, false)) return failure;
  data.splines.assign(path_.begin(), path_.end());
  // Receivers identify a path by its time.
  made_ = made_ == now ? made_ + std::chrono::milliseconds(1) : now;
  data.recordingTime = made_;
  return failure;
}

std::optional<std::string> RoutePlanner::go_on_planning() {
  const auto progress = planner_->advance(kPosesAPeriod);
  if (progress == GoalPlanner::Progress::kSearching) return std::nullopt;
  planning_ = false;
  if (progress == GoalPlanner::Progress::kFailed) {
    const std::string why = planner_->why();
    if (room_.phase() == MakingRoom::Phase::kPlans) room_.end();
    if (room_.is_active() && avoids_obstacles_) return std::nullopt;  // waits on
    if (detour_) return why;
    if (leads_there_) {
      (void)make_room();
      return why;
    }
    room_.end();
    if (avoids_obstacles_ && begin_plan(false)) return std::nullopt;
    take({});  // the old path has another destination
    return why;
  }
  if (room_.phase() == MakingRoom::Phase::kPlans) {
    take_path_aside();
    return std::nullopt;
  }
  if (!detour_) {
    if (waits_instead()) return std::nullopt;
    take(planner_->path());
    leads_there_ = true;
    room_.end();
    return std::nullopt;
  }
  before_ = path_;
  path_ = planner_->path();
  append_rest(before_, back_, path_);
  set_speeds(path_);
  is_new_ = true;
  return std::nullopt;
}

void RoutePlanner::take(std::span<const PolarSpline> path) {
  path_.assign(path.begin(), path.end());
  room_.unblock();
  is_new_ = true;
}

// --- commands

void RoutePlanner::set_waypoints(std::span<const Waypoint2d> waypoints) {
  waypoints_.assign(waypoints.begin(), waypoints.end());
  sent_by_.reset();
}

Result<void> RoutePlanner::make(const PathMakeData& command, tims::Address sender) {
  // Values that are not positive have no effect: the graphical interface sends -1.
  limits_ = settings_.limits;
  if (command.vMax > 0) limits_.speed_max = std::min<double>(command.vMax, settings_.chassis.vxMax);
  limits_.backward_max = std::min(limits_.backward_max, limits_.speed_max);
  if (command.accMax > 0) limits_.acceleration = command.accMax;
  if (command.decMax > 0) limits_.deceleration = command.decMax;
  if (command.omegaMax > 0) limits_.omega_max = command.omegaMax;
  // The graphical interface sends this message right after SET_DESTINATION, too: then the plan is
  // in progress or done. When the destination was refused, the message must not select another
  // path.
  if (std::exchange(sent_by_, {}) == sender) return {};
  return make_route();
}

Result<void> RoutePlanner::make_route() {
  route_.clear();
  for (const Waypoint2d& waypoint : waypoints_)
    if (waypoint.layer == settings_.layer) route_.push_back(waypoint);
  planning_ = must_replan_ = leads_there_ = false;
  destination_.reset();
  room_.end();
  const double* start_heading = begin_at_the_robot();
  if (route_.size() < 2) {
    take({});
    return {};
  }
  const auto made = make_path(route_, limits_, start_heading);
  if (!made) return made.error();
  take(*made);
  return {};
}

// A list of clicks is a path from the robot's pose at the first of them.
const double* RoutePlanner::begin_at_the_robot() {
  const bool clicks = !route_.empty() && std::abs(1.0 * route_[0].speed) == 1;
  if (!clicks || !located_) {
    clicked_.reset();
    return nullptr;
  }
  const Place first{1.0 * route_[0].x, 1.0 * route_[0].y};
  if (route_.size() == 1 || !clicked_ || clicked_->x != first.x || clicked_->y != first.y) {
    clicked_ = first;
    began_ = robot_;
  }
  Waypoint2d start = route_[0];
  start.x = whole_millimetres(began_.x);
  start.y = whole_millimetres(began_.y);
  route_.insert(route_.begin(), start);
  return &began_.rho;
}

Result<void> RoutePlanner::set_destination(const PathDestData& destination, tims::Address sender) {
  sent_by_ = sender;
  seen_.forget();
  const auto before = destination_;
  const bool led_there = std::exchange(leads_there_, false);
  destination_ = destination;
  room_.begin_destination();
  must_replan_ = !located_;
  if (must_replan_) return {};
  auto good = plan_destination();
  if (!good) {
    destination_ = before;
    leads_there_ = led_there;
  }
  return good;
}

Result<void> RoutePlanner::plan_destination() {
  auto good = begin_plan(true);
  if (good) return good;
  seen_.forget();  // what is seen no longer may have gone
  good = begin_plan(true);
  return good || leads_there_ ? good : begin_plan(false);
}

Result<void> RoutePlanner::begin_plan(bool avoids_obstacles) {
  const double target = direction_or_speed(destination_->speed);
  const double speed = std::abs(target) < kDirectionOnly ? 0 : std::abs(target);
  planner_->set_limits(limits_);
  avoids_obstacles_ = avoids_obstacles;
  survey();
  auto good =
      planner_->begin(space_, robot_, Pose::of(destination_->pos), target < 0 ? -1 : 1, speed);
  planning_ = good.ok();
  detour_ = false;
  return good;
}

Result<void> RoutePlanner::replan(const PathReplanData& from) {
  if (!located_) return not_now("the position is not known yet");
  if (planning_) return {};  // a plan is in progress
  if (room_.is_active()) return blocked_aside();
  if (path_.empty() && !destination_) return not_now("there is no path");
  const auto index = static_cast<std::size_t>(std::max(0, from.currSpline));
  const bool is_on_path = index < path_.size();
  if (!is_on_path && !destination_)
    return not_now("the path has " + std::to_string(path_.size()) + " splines only");
  OnPath at{index};
  if (is_on_path)
    at.distance = std::clamp(std::abs(1.0 * from.splinePos.x), 0.0, size(path_[index]));
  if (destination_) {
    room_.unblock();
    if (is_on_path) room_.block(at, length_of(std::span(path_).subspan(index)) - at.distance);
    if (room_.is_stuck(robot_) && !room_.has_offered(robot_) && make_room()) return {};
    auto good = plan_destination();
    return good || !make_room() ? good : Result<void>();
  }
  return plan_detour(at, std::max(0.0, 1.0 * from.distToObstacle));
}

// Returns to the path at the first place behind the obstacle for which a plan can start.
Result<void> RoutePlanner::plan_detour(const OnPath& at, double to_obstacle) {
  avoids_obstacles_ = true;
  survey();
  const double hull = settings_.chassis.boundaryFront + settings_.chassis.boundaryBack;
  const OnPath end = further(path_, at, to_obstacle + hull + kBehind.back());
  keep_to_corridor(space_, std::span(path_).subspan(at.index, end.index - at.index + 1),
                   {robot_.x, robot_.y}, hull);
  planner_->set_limits(limits_);
  Result<void> good = not_now("the obstacle extends to the end of the path");
  for (const double behind : kBehind) {
    back_ = further(path_, at, to_obstacle + hull + behind);
    good = planner_->begin(space_, robot_, pose_on(path_, back_));
    if (good) break;
  }
  planning_ = good.ok();
  detour_ = true;
  return good;
}

// --- making room

// Whoever stands in a door wants to pass, too; after an offer at this place, the detour is taken.
bool RoutePlanner::waits_instead() {
  if (!room_.is_long_detour(length_of(planner_->path()))) return false;
  if (room_.is_active()) return avoids_obstacles_;
  if (!leads_there_ || room_.has_offered(robot_)) return false;
  room_.offer(robot_);
  if (!make_room()) (void)plan_destination();
  return true;
}

// When there is no path around what blocks the path to the destination. False: not possible.
bool RoutePlanner::make_room() {
  if (!leads_there_ || !room_.may_begin()) return false;
  avoids_obstacles_ = true;
  survey();
  return room_.begin_aside(space_, path_, robot_) && plan_aside();
}

// In the space of the last survey.
bool RoutePlanner::plan_aside() {
  planner_->set_limits(limits_);
  planning_ = planner_->begin(space_, robot_, room_.place(), room_.sense()).ok();
  detour_ = false;
  if (!planning_) room_.end();
  return planning_;
}

// And on to the destination, along the path that was blocked; but it must not be driven.
void RoutePlanner::take_path_aside() {
  const bool is_first = std::exchange(leads_there_, false);
  if (is_first) before_ = path_;
  path_ = planner_->path();
  const std::size_t to_wait = path_.size();
  if (to_wait < kSplinesMax)
    path_.push_back(line(room_.place(), std::max(1.0, room_.to_blocked())));
  append_rest(before_, *room_.blocked_at(), path_);
  for (PolarSpline& spline : std::span(path_).subspan(to_wait))
    spline.vMax = spline.vStart = spline.vEnd = 0;
  is_new_ = true;
  room_.drive(is_first);
}

void RoutePlanner::go_on_aside(TimeStamp now) {
  const auto look = room_.step(now, robot_);
  if (look != MakingRoom::Look::kNot) (void)begin_plan(look == MakingRoom::Look::kForAPath);
}

// Somebody may have come to its other side.
Result<void> RoutePlanner::blocked_aside() {
  if (room_.phase() != MakingRoom::Phase::kDrives) return {};
  room_.turn_around();
  avoids_obstacles_ = true;
  survey();
  if (plan_aside()) return {};
  return plan_destination();
}

// --- free space

void RoutePlanner::survey() {
  if (map_.is_known)
    space_ = map_.space;
  else
    space_.clear({robot_.x - settings_.plan_width / 2, robot_.y - settings_.plan_width / 2});
  seen_.update(space_, map());
  if (avoids_obstacles_)
    for (const Place& mark : seen_.marks()) space_.occupy(mark);
  release_hull();
  space_.measure();
}

// The place of the vehicle itself is free.
void RoutePlanner::release_hull() {
  const ChassisParamData& hull = settings_.chassis;
  const auto step = static_cast<i32>(space_.cell() / 2);
  for (i32 x = -hull.boundaryBack.raw(); x <= hull.boundaryFront; x += step) {
    for (i32 y = -hull.boundaryLeft.raw(); y <= hull.boundaryRight; y += step) {
      const Pose at = robot_ + Pose{.x = 1.0 * x, .y = 1.0 * y};
      space_.release({at.x, at.y});
    }
  }
}

}  // namespace rack::path
