#include "components/pilot/path_follower.h"

#include <algorithm>
#include <cmath>

#include "components/path/path_maker.h"
#include "components/pilot/drive.h"

namespace rack::pilot {

namespace {

constexpr double kPathFollowerThere = 5;       // mm: tolerance at the end
constexpr double kPathFollowerAligned = 0.02;  // rad: tolerance of a turn at rest
constexpr double kMisaligned = 0.35;           // rad: above, turns at rest first
constexpr double kLost = 2;                    // rad off the path's heading
constexpr double kPerRadian =
    1000;                        // mm per rad of heading error, in the search for the nearest point
constexpr double kAsNear = 300;  // mm: among points that are this close, the first of the path wins
constexpr double kAtRest = 10;   // mm/s
constexpr double kBraking = 0.95;  // of the deceleration of the path

// The pose after driving with `command` for `time`.
Pose moved(const Pose& from, const PathFollower::Command& command, double time) {
  return moved(from, {.x = command.speed * time, .rho = command.omega * time});
}

}  // namespace

PathFollower::PathFollower(const FollowerSettings& settings) : settings_(settings) {
  path_.reserve(path::kSplinesMax);
  rest_.reserve(path::kSplinesMax);
}

// --- position on the path

void PathFollower::take(std::span<const PolarSpline> path, const Pose& at) {
  if (path.empty() || path.size() > path::kSplinesMax) {
    drop();
    return;
  }
  path_.assign(path.begin(), path.end());
  rest_.assign(path.size(), 0);
  for (std::size_t i = path.size() - 1; i-- > 0;)
    rest_[i] = rest_[i + 1] + path::size(path_[i + 1]);
  turning_ = false;
  state_ = State::kRunning;
  find_place(predicted(at));
}

void PathFollower::drop() {
  path_.clear();
  rest_.clear();
  state_ = State::kNoPath;
  index_ = 0;
  distance_ = 0;
  beside_ = {};
}

double PathFollower::rest() const {
  if (path_.empty()) return 0;
  return std::max(0.0, path::size(path_[index_]) - distance_) + rest_[index_];
}

void PathFollower::find_place(const Pose& at) {
  index_ = 0;
  distance_ = 0;
  // When the path starts here, it is joined at its start for any heading of the vehicle.
  const Pose start = path::pose_at(path_[0], 0);
  if (std::hypot(at.x - start.x, at.y - start.y) < kAsNear) {
    go_on(at);
    return;
  }
  double best = 1e300;
  for (std::size_t i = 0; i < path_.size(); ++i) {
    const PolarSpline& spline = path_[i];
    const path::Beside seen = path::beside(spline, at);
    const double distance = std::clamp(path::sense(spline) * seen.along, 0.0, path::size(spline));
    const Pose place = path::pose_at(spline, path::sense(spline) * distance);
    const double cost = std::hypot(at.x - place.x, at.y - place.y) +
                        kPerRadian * std::abs(signed_angle(at.rho - place.rho));
    if (cost >= best - kAsNear) continue;
    best = cost;
    index_ = i;
    distance_ = distance;
  }
  go_on(at);
}

// Advances to the following splines, up to the next stop.
void PathFollower::go_on(const Pose& at) {
  for (;;) {
    const PolarSpline& spline = path_[index_];
    beside_ = path::beside(spline, at);
    distance_ = path::sense(spline) * beside_.along;
    const bool next = distance_ > path::size(spline) && index_ + 1 < path_.size();
    if (next && !reverts() && path::runs_on(spline, path_[index_ + 1])) {
      ++index_;
      continue;
    }
    const bool earlier = distance_ < 0 && index_ > 0 && reverts();
    if (!earlier || !path::runs_on(path_[index_ - 1], spline)) return;
    --index_;
  }
}

// The commands of the lag time have not taken effect yet.
Pose PathFollower::predicted(const Pose& at) const {
  Pose pose = at;
  double left = std::min(seconds(settings_.lag), seconds(settings_.period) * (kCommandsMax - 1));
  const double period = seconds(settings_.period);
  const auto whole = static_cast<std::size_t>(left / period);
  const double part = left - period * static_cast<double>(whole);
  const auto command = [&](std::size_t ago) {
    return commands_[(newest_ + kCommandsMax - ago) % kCommandsMax];
  };
  pose = moved(pose, command(whole), part);
  for (std::size_t ago = whole; ago-- > 0;) pose = moved(pose, command(ago), period);
  return pose;
}

bool PathFollower::stops_ahead() const {
  return index_ + 1 == path_.size() || !path::runs_on(path_[index_], path_[index_ + 1]);
}

// Distance to the end of this spline in the direction of travel.
double PathFollower::ahead() const {
  return reverts() ? distance_ : path::size(path_[index_]) - distance_;
}

bool PathFollower::is_astray() const {
  const double room = static_cast<double>(path_[index_].lbo);
  if (room > 0 && std::abs(beside_.across) > room) return true;
  // A vehicle that can turn at rest turns towards the path instead.
  return settings_.chassis.minTurningRadius > 0 && std::abs(beside_.turned) > kLost;
}

// --- speed

// Ignores the acceleration phases of the profile: the vehicle accelerates as it can.
double PathFollower::profile(double further) const {
  std::size_t i = index_;
  double distance = std::max(0.0, distance_ + further);
  while (distance > path::size(path_[i]) && i + 1 < path_.size() &&
         path::runs_on(path_[i], path_[i + 1])) {
    distance -= path::size(path_[i]);
    ++i;
  }
  const PolarSpline& spline = path_[i];
  const double left = std::max(0.0, path::size(spline) - distance);
  const double end = spline.vEnd;
  return std::min<double>(spline.vMax, std::sqrt(end * end + 2 * kBraking * spline.decMax * left));
}

double PathFollower::steering_time(double from, double to) const {
  if (settings_.steering_rate <= 0) return 0;
  const double base = settings_.chassis.wheelBase;
  return std::abs(std::atan(base * to) - std::atan(base * from)) / settings_.steering_rate;
}

// Curvature of the path at the vehicle, or shortly ahead.
double PathFollower::curvature_at(double speed) const {
  const double here = path::curvature(path_[index_]);
  if (reverts() || stops_ahead()) return here;
  const double next = path::curvature(path_[index_ + 1]);
  const double early = seconds(settings_.period) / 2 + steering_time(here, next) / 2;
  return ahead() < std::abs(speed) * early ? next : here;
}

// --- output

PathFollower::Command PathFollower::follow(const Pose& at, double speed, double speed_safe) {
  if (reverts()) revert_left_ -= std::min(revert_left_, settings_.period);
  if (path_.empty() || state_ == State::kAstray) return give({});
  go_on(predicted(at));
  if (is_astray()) {
    state_ = State::kAstray;
    return give({});
  }
  if (state_ == State::kArrived && !reverts()) return give({});
  state_ = State::kRunning;
  const double slowest = settings_.chassis.vxMin;
  const double stops_in = kPathFollowerThere + slowest * seconds(settings_.period) / 2 +
                          slowest * slowest / (2 * std::max(1.0, 1.0 * settings_.chassis.decMax));
  if (ahead() <= stops_in &&
      (reverts() ? index_ == 0 || !path::runs_on(path_[index_ - 1], path_[index_])
                 : stops_ahead())) {
    if (reverts() || !leave_stop(speed)) return give({});
  }
  const bool may_turn = settings_.chassis.minTurningRadius == 0;
  const double missing = -beside_.turned;
  if (may_turn && std::abs(missing) > (turning_ ? kPathFollowerAligned : kMisaligned)) {
    turning_ = true;
    if (std::abs(speed) > kAtRest) return give({});
    return give(holds_ ? Command{} : turn_at_rest(missing));
  }
  turning_ = false;
  return give(drive(speed, speed_safe));
}

// At rest at the end of a spline: whether another one follows.
bool PathFollower::leave_stop(double speed) {
  if (std::abs(speed) > kAtRest || last().speed != 0) return false;
  if (index_ + 1 == path_.size()) {
    state_ = State::kArrived;
    return false;
  }
  const Pose end = path::pose_at(path_[index_], path::sense(path_[index_]) * distance_);
  Pose at = end;
  at.rho += beside_.turned;
  at.x -= beside_.across * std::sin(end.rho);
  at.y += beside_.across * std::cos(end.rho);
  ++index_;
  beside_ = path::beside(path_[index_], at);
  distance_ = path::sense(path_[index_]) * beside_.along;
  // Corners within the tolerance need no turn at rest.
  turning_ =
      std::abs(beside_.turned) > kPathFollowerAligned && settings_.chassis.minTurningRadius == 0;
  return true;
}

PathFollower::Command PathFollower::turn_at_rest(double missing) const {
  const double most = settings_.chassis.omegaMax;
  return {0, std::clamp(settings_.chassis.pilotParameterB * missing, -most, most)};
}

// The lowest speed that the vehicle can have after braking for one period.
PathFollower::Command PathFollower::braking(double speed_now, double sense) const {
  const double time = seconds(settings_.lag) + seconds(settings_.period) / 2;
  const double speed = std::abs(speed_now) - settings_.chassis.decMax * time;
  if (speed <= 0) return {};
  return {sense * speed, steer(sense * speed)};
}

PathFollower::Command PathFollower::drive(double speed_now, double speed_safe) {
  const PolarSpline& spline = path_[index_];
  const double sense = path::sense(spline) * (reverts() ? -1 : 1);
  const double before = std::abs(last().speed);
  const double period = seconds(settings_.period);
  double speed = std::min({settings_.speed_max, 1.0 * settings_.chassis.vxMax, speed_safe});
  if (sense < 0) speed = std::min(speed, 1.0 * kBackwardMax);
  if (reverts()) {
    const double left =
        std::max(0.0, distance_ + (index_ == 0 ? 0 : path::size(path_[index_ - 1])));
    speed = std::min({speed, 1.0 * spline.vMax, std::sqrt(2.0 * spline.decMax * left)});
  } else {
    speed = std::min({speed, profile(0), profile(before * period)});
  }
  if (holds_) speed = std::min(speed, before - spline.decMax * period);
  const double grown = before + std::min<double>(settings_.chassis.accMax, spline.accMax) * period;
  // A standing vehicle has to start with at least vxMin.
  speed = std::clamp(speed, 0.0, std::max(grown, 1.0 * settings_.chassis.vxMin));
  const Command still = braking(speed_now, sense);
  if (speed <= 0 || speed < std::abs(still.speed))
    return {sense * std::max(0.0, speed), still.omega};
  return {sense * speed, steer(sense * speed)};
}

double PathFollower::steer(double speed) const {
  const ChassisParamData& chassis = settings_.chassis;
  const double fast = std::max(std::abs(speed), 1.0);
  const double b = chassis.pilotParameterB;
  // A v = B / 2 gives a damping ratio of 0.7.
  const double a = std::min<double>(chassis.pilotParameterA, b / (2 * fast));
  const double steepest = std::asin(std::min(1.0, chassis.pilotVTransMax / fast));
  const double back = std::clamp(-a * beside_.across, -steepest, steepest);
  const double sense = speed < 0 ? -1 : 1;
  const double omega = speed * curvature_at(speed) + b * (sense * back - beside_.turned);
  const double tightest = chassis.minTurningRadius > 0 ? fast / chassis.minTurningRadius : 1e9;
  const double most = std::min<double>(chassis.omegaMax, tightest);
  return std::clamp(omega, -most, most);
}

PathFollower::Command PathFollower::give(const Command& command) {
  newest_ = (newest_ + 1) % kCommandsMax;
  commands_[newest_] = command;
  return command;
}

}  // namespace rack::pilot
