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
constexpr double kExplained = 150;  // mm: a point this near to a wall of the map is explained by it
constexpr std::size_t kMarksMax = 20000;  // marks of obstacles seen by the scanner
constexpr std::array<double, 5> kBehind = {2000, 4000, 7000, 12000,
                                           20000};  // distances behind an obstacle, mm
constexpr i32 kLandmark = 1;
constexpr double kTrailEvery = 100;      // mm
constexpr std::size_t kTrailMost = 150;  // places
constexpr double kLaneAhead = 8000;      // mm
constexpr double kNoProgress = 200;      // mm
constexpr double kDetourMost = 6000;     // longer than the blocked path, mm: people walk on sooner
constexpr double kOfferedHere = 1000;    // mm
constexpr double kAtPlaceAside = 250;    // mm
constexpr int kTimesAsideMost = 5;       // for one destination
constexpr auto kDrivesAsideMost = std::chrono::seconds(60);
constexpr auto kWaitsAside = std::chrono::seconds(3);       // at least, for the person to come
constexpr auto kWaitsAsideMost = std::chrono::seconds(20);  // then drives as if they had gone
constexpr auto kLooksFromAside = std::chrono::seconds(2);

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
  reserve_all(scan_);
  path_.reserve(kSplinesMax);
  before_.reserve(kSplinesMax);
  marks_.reserve(kMarksMax);
  waypoints_.reserve(kWaypointsMax);
  trail_.reserve(kTrailMost);
}

Result<void> RoutePlanner::begin(const RouteSettings& settings, PlanningMap map) {
  located_ = seen_ = planning_ = false;
  blocked_at_.reset();
  replanned_at_.reset();
  offered_at_.reset();
  aside_.reset();
  times_aside_ = 0;
  trail_.clear();
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
  follow_trail();
}

void RoutePlanner::take_scan(const Scan2dData& scan) {
  scan_ = scan;
  seen_from_ = robot_;
  seen_ = true;
}

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
  if (aside_) go_on_aside(now);
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
    if (aside_ && aside_->phase == Aside::Phase::kPlans) aside_.reset();
    if (aside_ && avoids_obstacles_) return std::nullopt;  // waits on
    if (detour_) return why;
    if (leads_there_) {
      (void)make_room();
      return why;
    }
    aside_.reset();
    if (avoids_obstacles_ && begin_plan(false)) return std::nullopt;
    take({});  // the old path has another destination
    return why;
  }
  if (aside_ && aside_->phase == Aside::Phase::kPlans) {
    take_path_aside();
    return std::nullopt;
  }
  if (!detour_) {
    if (waits_instead()) return std::nullopt;
    take(planner_->path());
    leads_there_ = true;
    aside_.reset();
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
  blocked_at_.reset();
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
  aside_.reset();
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
  marks_.clear();
  const auto before = destination_;
  const bool led_there = std::exchange(leads_there_, false);
  destination_ = destination;
  aside_.reset();
  replanned_at_.reset();
  offered_at_.reset();
  times_aside_ = 0;
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
  marks_.clear();  // what is seen no longer may have gone
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
  if (aside_) return blocked_aside();
  if (path_.empty() && !destination_) return not_now("there is no path");
  const auto index = static_cast<std::size_t>(std::max(0, from.currSpline));
  const bool is_on_path = index < path_.size();
  if (!is_on_path && !destination_)
    return not_now("the path has " + std::to_string(path_.size()) + " splines only");
  OnPath at{index};
  if (is_on_path)
    at.distance = std::clamp(std::abs(1.0 * from.splinePos.x), 0.0, size(path_[index]));
  if (destination_) {
    blocked_at_.reset();
    if (is_on_path) {
      blocked_at_ = at;
      direct_ = length_of(std::span(path_).subspan(index)) - at.distance;
    }
    if (is_stuck() && !has_offered() && make_room()) return {};
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

void RoutePlanner::follow_trail() {
  if (!trail_.empty() &&
      std::hypot(trail_.back().x - robot_.x, trail_.back().y - robot_.y) < kTrailEvery)
    return;
  if (trail_.size() == kTrailMost) trail_.erase(trail_.begin());
  trail_.push_back({robot_.x, robot_.y});
}

// Plans do not help a vehicle that has not moved since the last one.
bool RoutePlanner::is_stuck() {
  const auto before = std::exchange(replanned_at_, Place{robot_.x, robot_.y});
  return before && std::hypot(robot_.x - before->x, robot_.y - before->y) < kNoProgress;
}

bool RoutePlanner::has_offered() const {
  return offered_at_ &&
         std::hypot(offered_at_->x - robot_.x, offered_at_->y - robot_.y) < kOfferedHere;
}

// Before a detour that is much longer than the blocked path, the vehicle makes room: whoever stands
// in a door wants to pass, too. At each place once; then it takes the detour.
bool RoutePlanner::waits_instead() {
  if (!blocked_at_ || length_of(planner_->path()) <= direct_ + kDetourMost) return false;
  if (aside_) return avoids_obstacles_;
  if (!leads_there_ || has_offered()) return false;
  offered_at_ = {robot_.x, robot_.y};
  if (!make_room()) (void)plan_destination();
  return true;
}

// When there is no path around what blocks the path to the destination. False: there is no place
// aside, or the vehicle was there often enough.
bool RoutePlanner::make_room() {
  if (!leads_there_ || !blocked_at_ || times_aside_ == kTimesAsideMost) return false;
  lane_ = trail_;
  const OnPath end = further(path_, *blocked_at_, kLaneAhead);
  for (OnPath at = *blocked_at_; at.index < end.index || at.distance < end.distance;
       at = further(path_, at, kTrailEvery)) {
    const Pose place = pose_on(path_, at);
    lane_.push_back({place.x, place.y});
  }
  avoids_obstacles_ = true;
  survey();
  const HullDiscs hull(hull_of(settings_.chassis));
  const auto place = place_aside(space_, reach_,
                                 {.room_to_pass = hull.half_width(),
                                  .room_to_turn = hull.reach() + space_.cell(),
                                  .half_width = half_width(settings_.chassis)},
                                 {robot_.x, robot_.y}, lane_);
  if (!place) return false;
  Aside aside{.place = {.x = place->x, .y = place->y}, .blocked = robot_};
  aside.place.rho = heading(std::atan2(robot_.y - place->y, robot_.x - place->x));
  // One that turns at rest looks where it drives.
  aside.sense = turns_at_rest(settings_.chassis) ? 1 : -1;
  aside_ = aside;
  return begin_aside();
}

bool RoutePlanner::begin_aside() {
  aside_->phase = Aside::Phase::kPlans;
  avoids_obstacles_ = true;
  survey();
  planner_->set_limits(limits_);
  planning_ = planner_->begin(space_, robot_, aside_->place, aside_->sense).ok();
  detour_ = false;
  if (!planning_) aside_.reset();
  return planning_;
}

// And on to the destination, along the path that was blocked; but it must not be driven.
void RoutePlanner::take_path_aside() {
  if (leads_there_) {
    before_ = path_;
    ++times_aside_;
  }
  path_ = planner_->path();
  const std::size_t to_wait = path_.size();
  const double to_blocked =
      std::hypot(aside_->blocked.x - aside_->place.x, aside_->blocked.y - aside_->place.y);
  if (to_wait < kSplinesMax) path_.push_back(line(aside_->place, std::max(1.0, to_blocked)));
  append_rest(before_, *blocked_at_, path_);
  for (PolarSpline& spline : std::span(path_).subspan(to_wait))
    spline.vMax = spline.vStart = spline.vEnd = 0;
  leads_there_ = false;
  is_new_ = true;
  aside_->phase = Aside::Phase::kDrives;
  aside_->since = 0;
}

void RoutePlanner::go_on_aside(TimeStamp now) {
  if (planning_) return;
  if (aside_->since == 0) aside_->since = now;
  const auto elapsed = now - aside_->since;
  if (aside_->phase == Aside::Phase::kDrives) {
    const bool is_there =
        std::hypot(robot_.x - aside_->place.x, robot_.y - aside_->place.y) < kAtPlaceAside;
    if (!is_there && elapsed < kDrivesAsideMost) return;
    aside_->phase = Aside::Phase::kWaits;
    aside_->since = aside_->looked = now;
    return;
  }
  if (elapsed < kWaitsAside || now - aside_->looked < kLooksFromAside) return;
  aside_->looked = now;
  (void)begin_plan(elapsed < kWaitsAsideMost);
}

// Somebody may have come to its other side.
Result<void> RoutePlanner::blocked_aside() {
  if (aside_->phase != Aside::Phase::kDrives) return {};
  aside_->sense = -aside_->sense;
  if (begin_aside()) return {};
  return plan_destination();
}

// --- free space

void RoutePlanner::survey() {
  if (map_.is_known)
    space_ = map_.space;
  else
    space_.clear({robot_.x - settings_.plan_width / 2, robot_.y - settings_.plan_width / 2});
  if (seen_) {
    forget_what_has_gone();
    remember_obstacles();
  }
  if (avoids_obstacles_)
    for (const Place& mark : marks_) space_.occupy(mark);
  release_hull();
  space_.measure();
}

// An obstacle has gone where the scanner now looks through it.
void RoutePlanner::forget_what_has_gone() {
  constexpr std::size_t kDirections = 720;
  constexpr double kBehindIt = 200;  // mm
  std::array<double, kDirections> seen{};
  const auto direction_of = [](double x, double y) {
    return static_cast<std::size_t>(heading(std::atan2(y, x)) / (2 * kPi) * kDirections) %
           kDirections;
  };
  for (const ScanPoint& point : scan_.points) {
    if ((point.type & scan_point::kInvalid) != 0) continue;
    double& nearest = seen.at(direction_of(point.x, point.y));
    const double range = std::hypot(point.x.raw(), point.y.raw());
    nearest = nearest == 0 ? range : std::min(nearest, range);
  }
  std::erase_if(marks_, [&](const Place& mark) {
    const Pose at = Pose{.x = mark.x, .y = mark.y} - seen_from_;
    const std::size_t direction = direction_of(at.x, at.y);
    const double needed = std::hypot(at.x, at.y) + kBehindIt;
    bool any = false;
    for (const std::size_t beside : {kDirections - 1, std::size_t{0}, std::size_t{1}}) {
      const double range = seen.at((direction + beside) % kDirections);
      if (range != 0 && range < needed) return false;
      any = any || range != 0;
    }
    return any;
  });
}

void RoutePlanner::remember_obstacles() {
  for (const ScanPoint& point : scan_.points) {
    if ((point.type & scan_point::kInvalid) != 0 ||
        (point.type & scan_point::kClassMask) == kLandmark || marks_.size() == kMarksMax)
      continue;
    const Pose at = seen_from_ + Pose{.x = 1.0 * point.x, .y = 1.0 * point.y};
    const Place place{at.x, at.y};
    if (!space_.contains(place) || space_.occupied(place)) continue;
    if (map_.is_known && map_.space.clearance(place) < kExplained) continue;
    marks_.push_back(place);
  }
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
