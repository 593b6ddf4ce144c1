#include "components/path/goal_planner.h"

#include <algorithm>
#include <cmath>

namespace rack::path {

namespace {

constexpr double kGoalPlannerCellsMax = 700;  // of a search over cells, per direction
constexpr double kLastLeg = 100;              // mm, of a vehicle that turns at rest, at least
constexpr double kLastLegMost = 3000;         // mm
constexpr double kAstray = 150;     // mm: minimum lateral deviation of a car that must be possible
constexpr double kReserve = 1.1;    // factor on the minimum radius: reserve to return to the path
constexpr double kLookEvery = 200;  // mm
constexpr double kTurnsFreely = 0.3;  // rad: so far a hull turns without swinging out much
constexpr double kBackMost = 800;     // mm
constexpr double kBackSpeed = 200;    // mm/s
constexpr double kLeaves = 1000;  // mm: a vehicle too near to an obstacle must be free after that

HullDiscs::Size bare(HullDiscs::Size hull) {
  hull.margin = 0;
  return hull;
}

std::string place_name(const Pose& at) {
  return "(" + std::to_string(std::lround(at.x)) + ", " + std::to_string(std::lround(at.y)) + ")";
}

tims::Error refused(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

bool finite(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.rho);
}

}  // namespace

GoalPlanner::GoalPlanner(const PlanSettings& settings) : settings_(settings), hull_(settings.hull) {
  settings_.limits.half_width = settings.hull.half_width;
  path_.reserve(kSplinesMax);
  corners_.reserve(kSplinesMax);
  if (settings_.limits.radius_min == 0)
    cells_.reserve(static_cast<std::size_t>(kGoalPlannerCellsMax * kGoalPlannerCellsMax));
}

void GoalPlanner::set_limits(const PathLimits& limits) {
  const PathLimits before = settings_.limits;
  settings_.limits = limits;
  settings_.limits.radius_min = before.radius_min;
  settings_.limits.half_width = before.half_width;
}

tims::Result<void> GoalPlanner::begin(const FreeSpace& space, const Pose& start, const Pose& goal,
                                      double sense, double speed) {
  if (auto good = check(settings_.limits); !good) return good;
  if (!finite(start) || !finite(goal))
    return refused("the coordinates of the start or the goal are not valid");
  if (!space.contains({start.x, start.y}))
    return refused("the vehicle is at " + place_name(start) + ", outside of the map");
  if (!space.contains({goal.x, goal.y}))
    return refused("the goal " + place_name(goal) + " is outside of the map");
  // The discs exceed the hull a little; where the vehicle can turn, there is room for it.
  const bool turns = settings_.limits.radius_min == 0 &&
                     space.clearance({goal.x, goal.y}) >= hull_.turning_radius();
  if (!turns && space.room(hull_, goal) < 0)
    return refused("there is no room for the vehicle at the goal " + place_name(goal));
  space_ = &space;
  start_ = start;
  goal_ = goal;
  sense_ = sense < 0 ? -1 : 1;
  speed_ = speed;
  path_.clear();
  if (settings_.limits.radius_min == 0) return {};
  HybridSearch::Settings search;
  search.radius = std::ceil(kReserve * settings_.limits.radius_min);
  search.hull = hull_;
  search.change = search.radius;
  if (sense_ < 0) search.backward = 1 / search.backward;
  poses_.begin(space, search, start, goal);
  return {};
}

GoalPlanner::Progress GoalPlanner::advance(int poses) {
  if (settings_.limits.radius_min == 0) return over_cells();
  const Progress progress = poses_.advance(poses);
  if (progress == Progress::kFailed)
    return fail("no path was found from " + place_name(start_) + " to " + place_name(goal_));
  if (progress == Progress::kFound) lay_pieces();
  return progress;
}

GoalPlanner::Progress GoalPlanner::fail(std::string why) {
  why_ = std::move(why);
  path_.clear();
  return Progress::kFailed;
}

// --- over cells

GoalPlanner::Progress GoalPlanner::over_cells() {
  for (const bool turns_everywhere : {true, false}) {
    const double room = turns_everywhere ? hull_.turning_radius() : hull_.half_width();
    if (!corners({start_.x, start_.y}, room)) continue;
    go_back_to_turn(room);
    if (auto good = lay_waypoints(room, turns_everywhere); !good)
      return fail(good.error().detail());
    return Progress::kFound;
  }
  return fail("no path with room to turn was found from " + place_name(start_) + " to " +
              place_name(goal_));
}

// Finds the corners of a path with that clearance, from the start to the goal.
bool GoalPlanner::corners(const Place& start, double room) {
  const double width =
      static_cast<double>(std::max(space_->rows(), space_->columns())) / kGoalPlannerCellsMax;
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::ceil(width)));
  const Place goal = before_goal();
  // Searches from the goal, so that the trace is in the order of travel.
  const GridSearch::Settings settings{.room = room,
                                      .comfort = settings_.comfort,
                                      .stride = stride,
                                      .eased_at = start,
                                      .eased_within = kLeaves,
                                      .eased_room = room_to_leave(start)};
  if (!cells_.run(*space_, settings, goal, &start)) return false;
  cells_.trace(start, cells_on_path_);
  cells_on_path_.front() = start;
  if (cells_on_path_.size() == 1)
    cells_on_path_.push_back(goal);
  else
    cells_on_path_.back() = goal;
  corners_.assign(1, start);
  for (std::size_t i = 0; i + 1 < cells_on_path_.size();) {
    i = next_corner(i, room);
    if (i == 0) return false;
    corners_.push_back(cells_on_path_[i]);
  }
  return true;
}

// The clearance at the start, but for the size of a cell, and not less than the bare hull needs.
double GoalPlanner::room_to_leave(const Place& start) const {
  return std::max(space_->clearance(start) - space_->cell(), settings_.hull.half_width);
}

// When its first corner requires a turn, and its hull would swing into something.
void GoalPlanner::go_back_to_turn(double room) {
  goes_back_ = false;
  const double direction = std::atan2(corners_[1].y - corners_[0].y, corners_[1].x - corners_[0].x);
  const double turn = signed_angle(direction - start_.rho + (sense_ < 0 ? kPi : 0));
  if (std::abs(turn) < kTurnsFreely) return;
  const auto back = back_where_it_turns();
  if (!back) return;
  const Place start{start_.x, start_.y};
  goes_back_ = corners(*back, room);
  if (goes_back_)
    corners_.insert(corners_.begin(), start);
  else
    (void)corners(start, room);
}

// The nearest such place straight behind it, if it cannot turn where it is.
std::optional<Place> GoalPlanner::back_where_it_turns() const {
  const double to_turn = HullDiscs(bare(settings_.hull)).turning_radius() + space_->cell();
  if (space_->clearance({start_.x, start_.y}) >= to_turn) return std::nullopt;
  for (double distance = space_->cell(); distance <= kBackMost; distance += space_->cell()) {
    const Place place{start_.x - sense_ * distance * std::cos(start_.rho),
                      start_.y - sense_ * distance * std::sin(start_.rho)};
    if (!space_->contains(place) || space_->clearance(place) < settings_.hull.half_width) break;
    if (space_->clearance(place) >= to_turn) return place;
  }
  return std::nullopt;
}

// The farthest place of the path with a free line of sight from `from`, where the vehicle can turn;
// 0: none.
std::size_t GoalPlanner::next_corner(std::size_t from, double room) const {
  std::size_t next = 0;
  double least_clearance = 1e9;
  for (std::size_t k = from + 1; k < cells_on_path_.size(); ++k) {
    const bool last = k + 1 == cells_on_path_.size();
    least_clearance = std::min(least_clearance, space_->clearance(cells_on_path_[k]));
    const double straight = space_->clearance(cells_on_path_[from], cells_on_path_[k]);
    // At the ends, the vehicle stands with the room that is there.
    const bool at_an_end = k == from + 1 && (from == 0 || last);
    const Place& start = cells_on_path_.front();
    const bool leaves =
        from == 0 && straight >= room_to_leave(start) &&
        std::hypot(cells_on_path_[k].x - start.x, cells_on_path_[k].y - start.y) < kLeaves;
    if (straight < room && !at_an_end && !leaves) break;
    // Does not cut a corner that the path keeps a distance to.
    if (straight < std::min(least_clearance - space_->cell(), room + settings_.comfort) &&
        next != 0)
      break;
    if (last || space_->clearance(cells_on_path_[k]) >= hull_.turning_radius()) next = k;
  }
  return next;
}

// The nearest place on the line to the goal where the vehicle can turn; if there is none, near the
// goal: perhaps it comes in that direction.
Place GoalPlanner::before_goal() const {
  const auto back = [&](double distance) {
    return Place{goal_.x - sense_ * distance * std::cos(goal_.rho),
                 goal_.y - sense_ * distance * std::sin(goal_.rho)};
  };
  for (double distance = kLastLeg; distance <= kLastLegMost; distance += space_->cell()) {
    const Place place = back(distance);
    if (!space_->contains(place) ||
        space_->clearance(place, {goal_.x, goal_.y}) < hull_.half_width())
      break;
    if (space_->clearance(place) >= hull_.turning_radius()) return place;
  }
  return back(kLastLeg);
}

tims::Result<void> GoalPlanner::lay_waypoints(double room, bool rounds) {
  std::vector<Waypoint2d> waypoints;
  corners_.push_back({goal_.x, goal_.y});
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    Waypoint2d waypoint;
    waypoint.x = whole_millimetres(corners_[i].x);
    waypoint.y = whole_millimetres(corners_[i].y);
    const double target = speed_ > 0 ? speed_ : settings_.limits.speed_max;
    const bool goes_back = goes_back_ && i == 1;
    waypoint.speed =
        static_cast<i32>(goes_back ? -sense_ * kBackSpeed : sense_ * std::max(target, 10.0));
    const double spare = i == 0 ? 0 : space_->clearance(corners_[i - 1], corners_[i]) - room;
    waypoint.lbo = whole_millimetres(settings_.limits.half_width + std::max(1.0, spare));
    // A curve as narrow as the last leg is short would need more room than turning at rest.
    const bool begins_last_leg = i + 2 == corners_.size();
    waypoint.maxRadius = rounds && !begins_last_leg && !goes_back ? 0 : 1;
    waypoint.id = static_cast<i32>(i);
    waypoints.push_back(waypoint);
  }
  auto made = make_path(waypoints, settings_.limits);
  if (!made) return made.error();
  path_.assign(made->begin(), made->end());
  // The corridor is as wide as the free space beside the path allows.
  for (PolarSpline& spline : path_)
    spline.lbo =
        std::max(spline.lbo.raw(), whole_millimetres(settings_.limits.half_width + kAstray));
  return {};
}

// --- from pieces

void GoalPlanner::lay_pieces() {
  Pose at = start_;
  for (const Piece& piece : poses_.pieces()) {
    if (path_.size() == kSplinesMax) break;
    const auto radius =
        static_cast<i32>(piece.curvature == 0 ? 0 : std::lround(1 / piece.curvature));
    PolarSpline spline = radius == 0 ? line(at, piece.length) : arc(at, radius, piece.length);
    double room = space_->room(hull_, at);
    const double length = std::abs(piece.length);
    for (int look = 1; look * kLookEvery < length; ++look) {
      const double signed_distance = std::copysign(look * kLookEvery, piece.length);
      room = std::min(room, space_->room(hull_, driven(at, {piece.curvature, signed_distance})));
    }
    at = driven(at, piece);
    spline.basepoint.x = whole_millimetres(at.x);
    spline.basepoint.y = whole_millimetres(at.y);
    spline.basepoint.speed = static_cast<i32>(std::copysign(std::max(10.0, speed_), piece.length));
    spline.lbo = whole_millimetres(settings_.limits.half_width + std::max(kAstray, room));
    limit_speed(spline, settings_.limits, speed_ > 0 ? speed_ : settings_.limits.speed_max);
    path_.push_back(spline);
  }
  set_speeds(path_);
}

}  // namespace rack::path
