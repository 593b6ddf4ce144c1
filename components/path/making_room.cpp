#include "components/path/making_room.h"

#include <cmath>

#include "components/path/vehicle.h"

namespace rack::path {
namespace {

constexpr double kTrailEvery = 100;      // mm
constexpr std::size_t kTrailMost = 150;  // places
constexpr double kLaneAhead = 8000;      // mm
constexpr double kNoProgress = 200;      // mm
constexpr double kDetourMost = 6000;     // longer than the blocked path, mm: people walk on sooner
constexpr double kOfferedHere = 1000;    // mm
constexpr double kAtPlace = 250;         // mm
constexpr int kTimesMost = 5;            // for one destination
constexpr auto kDrivesMost = std::chrono::seconds(60);
constexpr auto kWaitsLeast = std::chrono::seconds(3);  // for the person to come
constexpr auto kWaitsMost = std::chrono::seconds(20);  // then drives as if they had gone
constexpr auto kLooksEvery = std::chrono::seconds(2);

Place place_of(const Pose& pose) { return {pose.x, pose.y}; }

double distance(const Place& a, const Place& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

MakingRoom::MakingRoom() { trail_.reserve(kTrailMost); }

void MakingRoom::begin(const ChassisParamData& chassis) {
  chassis_ = chassis;
  trail_.clear();
  blocked_at_.reset();
  begin_destination();
}

void MakingRoom::begin_destination() {
  phase_ = Phase::kNo;
  replanned_at_.reset();
  offered_at_.reset();
  times_ = 0;
}

void MakingRoom::follow(const Pose& robot) {
  if (!trail_.empty() && distance(trail_.back(), place_of(robot)) < kTrailEvery) return;
  if (trail_.size() == kTrailMost) trail_.erase(trail_.begin());
  trail_.push_back(place_of(robot));
}

void MakingRoom::block(const OnPath& at, double direct) {
  blocked_at_ = at;
  direct_ = direct;
}

bool MakingRoom::is_stuck(const Pose& robot) {
  const auto before = std::exchange(replanned_at_, place_of(robot));
  return before && distance(*before, place_of(robot)) < kNoProgress;
}

bool MakingRoom::is_long_detour(double length) const {
  return blocked_at_ && length > direct_ + kDetourMost;
}

bool MakingRoom::has_offered(const Pose& robot) const {
  return offered_at_ && distance(*offered_at_, place_of(robot)) < kOfferedHere;
}

bool MakingRoom::may_begin() const { return blocked_at_ && times_ < kTimesMost; }

bool MakingRoom::begin_aside(const FreeSpace& space, std::span<const PolarSpline> path,
                             const Pose& robot) {
  const auto place = find(space, path, robot);
  if (!place) return false;
  place_ = {.x = place->x, .y = place->y};
  place_.rho = heading(std::atan2(robot.y - place->y, robot.x - place->x));
  left_ = robot;
  // One that turns at rest looks where it drives.
  sense_ = turns_at_rest(chassis_) ? 1 : -1;
  phase_ = Phase::kPlans;
  return true;
}

std::optional<Place> MakingRoom::find(const FreeSpace& space, std::span<const PolarSpline> path,
                                      const Pose& robot) {
  lane_ = trail_;
  const OnPath end = further(path, *blocked_at_, kLaneAhead);
  for (OnPath at = *blocked_at_; at.index < end.index || at.distance < end.distance;
       at = further(path, at, kTrailEvery))
    lane_.push_back(place_of(pose_on(path, at)));
  const HullDiscs hull(hull_of(chassis_));
  return place_aside(space, reach_,
                     {.room_to_pass = hull.half_width(),
                      .room_to_turn = hull.reach() + space.cell(),
                      .half_width = half_width(chassis_)},
                     place_of(robot), lane_);
}

void MakingRoom::turn_around() {
  sense_ = -sense_;
  phase_ = Phase::kPlans;
}

void MakingRoom::drive(bool is_first) {
  if (is_first) ++times_;
  phase_ = Phase::kDrives;
  since_ = 0;
}

MakingRoom::Look MakingRoom::step(TimeStamp now, const Pose& robot) {
  if (since_ == 0) since_ = now;
  const auto elapsed = now - since_;
  if (phase_ == Phase::kDrives) {
    const bool is_there = distance(place_of(robot), place_of(place_)) < kAtPlace;
    if (!is_there && elapsed < kDrivesMost) return Look::kNot;
    phase_ = Phase::kWaits;
    since_ = looked_ = now;
    return Look::kNot;
  }
  if (elapsed < kWaitsLeast || now - looked_ < kLooksEvery) return Look::kNot;
  looked_ = now;
  return elapsed < kWaitsMost ? Look::kForAPath : Look::kAsIfItHadGone;
}

double MakingRoom::to_blocked() const { return distance(place_of(left_), place_of(place_)); }

}  // namespace rack::path
