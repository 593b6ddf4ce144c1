#include "components/pilot/path_driver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "components/path/vehicle.h"

namespace rack::pilot {
namespace {

using State = PathFollower::State;
using std::chrono::milliseconds;

constexpr int kMissing = 3;                 // messages of an input, then the vehicle stops
constexpr milliseconds kExtrapolated{500};  // maximum age of a position
constexpr std::size_t kSplinesShown = 10;
constexpr std::size_t kDestinationsMax = 1000;  // in a message
constexpr double kStands = 20;                  // mm/s
constexpr i32 kHour = 3600000;                  // ms
constexpr milliseconds kAskNextAgain{5000};     // after the path has refused a destination

// The bounds of PilotPath's parameters; a recording may contain any value.
bool is_sensible(const PathDriverSettings& settings) {
  const auto is_time = [](i32 time) { return time >= 0 && time <= kHour; };
  return settings.maxSpeed > 0 && settings.periodTime > 0 && is_time(settings.periodTime) &&
         is_time(settings.lag) && settings.steeringRate >= 0 && is_time(settings.scanPeriod) &&
         is_time(settings.positionPeriod) && is_time(settings.chassisPeriod) &&
         is_time(settings.pathPeriod);
}

}  // namespace

PathDriver::PathDriver() {
  reserve_all(inputs_.scan);
  reserve_all(inputs_.path);
  destinations_.reserve(kDestinationsMax);
}

Result<void> PathDriver::begin(PathDriverSettings settings) {
  if (!is_sensible(settings))
    return tims::Error(tims::Errc::kInvalidArgument, "the settings are out of range");
  ChassisParamData& chassis = settings.chassis;
  const milliseconds reaction(settings.lag + settings.periodTime +
                              (settings.looks != 0 ? settings.scanPeriod : 0));
  const double fastest = std::min<double>(settings.maxSpeed, chassis.vxMax);
  if (settings.looks != 0) {
    if (auto good = check_braking(chassis, fastest, reaction); !good) return good;
  }
  if (path::turns_at_rest(chassis)) chassis.minTurningRadius = 0;
  settings.pathPeriod = std::max(1, settings.pathPeriod);
  settings_ = settings;
  follower_.emplace(FollowerSettings{chassis, fastest, period(), milliseconds(settings.lag),
                                     radians(settings.steeringRate)});
  stop_.emplace(chassis, reaction);
  inputs_.position = {};
  inputs_.chassis = {};
  inputs_.path.recordingTime = 0;
  inputs_.path.splines.clear();
  inputs_.scan.recordingTime = 0;
  inputs_.scan.points.clear();
  cycle_ = {};
  at_ = seen_from_ = {};
  command_ = {};
  missing_ = Why::kDrives;
  safe_ = 0;
  seen_ = located_ = is_unsure_ = reached_ = awaits_next_ = false;
  state_ = pilot_state::kIdle;
  destinations_.clear();
  blocked_ = hold_left_ = refused_ = watchdog_ = watchdog_left_ = milliseconds(0);
  is_held_ = false;
  taken_ = 0;
  return {};
}

// --- one period

ChassisMoveData PathDriver::step(const PathCycle& cycle) {
  cycle_ = cycle;
  located_ = located_ || (cycle.came & PathCycle::kPosition) != 0;
  if ((cycle.came & PathCycle::kScan) != 0) {
    seen_ = true;
    seen_from_ = pose_at(inputs_.scan.recordingTime);
  }
  at_ = pose_at(cycle.time);
  take_path();
  command_ = decide();
  check_refusal();
  return {static_cast<i32>(std::lround(command_.speed)), 0, static_cast<f32>(command_.omega)};
}

// Extrapolates the newest position by the current speed.
Pose PathDriver::pose_at(TimeStamp time) const {
  const Pose pose = Pose::of(inputs_.position.pos);
  const ChassisData& chassis = inputs_.chassis;
  const auto old = std::clamp(time - inputs_.position.recordingTime, -kExtrapolated, kExtrapolated);
  const double seconds = std::chrono::duration<double>(old).count();
  return pose + Pose{.x = static_cast<double>(chassis.vx) * seconds,
                     .y = static_cast<double>(chassis.vy) * seconds,
                     .rho = static_cast<double>(chassis.omega) * seconds};
}

// A path is new when its time differs.
void PathDriver::take_path() {
  const PathData& path = inputs_.path;
  if (!located_ || path.recordingTime == taken_) return;
  taken_ = path.recordingTime;
  follower_->take(path.splines, at_);
  blocked_ = milliseconds(0);
  reached_ = false;
  if (!path.splines.empty() && std::exchange(awaits_next_, false))
    destinations_.erase(destinations_.begin());
  if (path.splines.empty()) {
    // The requested plan has failed; otherwise there is no path yet.
    if (state_ == pilot_state::kPlanning) state_ = pilot_state::kPathError;
    return;
  }
  state_ = pilot_state::kRunning;
}

PathFollower::Command PathDriver::decide() {
  if (!located_) return {};
  check_hold_time();
  check_watchdog();
  follower_->hold(is_held_ || is_unwatched());
  check_deviation();
  missing_ = missing();
  const bool knows = missing_ == Why::kDrives;
  safe_ = 0;
  if (knows)
    safe_ = settings_.looks != 0 ? stop_->speed_max(inputs_.scan, seen_from_, at_, *follower_)
                                 : static_cast<double>(settings_.chassis.vxMax);
  auto command = follower_->follow(at_, inputs_.chassis.vx, safe_);
  const bool turns_at_rest = command.speed == 0 && command.omega != 0;
  if (turns_at_rest && settings_.looks != 0 &&
      !stop_->may_turn(inputs_.scan, seen_from_, at_, command.omega)) {
    command.omega = 0;
    safe_ = 0;
  }
  const bool is_driving = follower_->state() == State::kRunning && !follower_->holds();
  const bool stands = std::abs(static_cast<double>(inputs_.chassis.vx)) < kStands;
  if (!is_driving || !stands || (knows && safe_ > 0))
    blocked_ = milliseconds(0);
  else if (knows)  // what is missing for a moment does not clear the path
    blocked_ += period();
  if (follower_->state() == State::kAstray) state_ = pilot_state::kPathError;
  if (follower_->state() == State::kArrived && state_ == pilot_state::kRunning) {
    state_ = pilot_state::kIdle;
    reached_ = true;
  }
  return command;
}

// While messages are missing, obstacles, position or path are unknown; the vehicle resumes when
// they arrive again. An uncertain position must not be used for steering.
PathDriver::Why PathDriver::missing() const {
  const auto is_missing = [&](i32 silence, i32 period_of_input) {
    return silence * period() >= kMissing * std::max(milliseconds(period_of_input), period());
  };
  if (is_unsure_) return Why::kUnsure;
  if (is_missing(cycle_.positionSilence, settings_.positionPeriod)) return Why::kPositionMissing;
  if (is_missing(cycle_.chassisSilence, settings_.chassisPeriod)) return Why::kChassisMissing;
  if (is_missing(cycle_.pathSilence, settings_.pathPeriod)) return Why::kPathMissing;
  if (settings_.looks == 0) return Why::kDrives;
  const milliseconds scan_period(settings_.scanPeriod);
  const milliseconds old = cycle_.time - inputs_.scan.recordingTime;
  const bool sees = seen_ && cycle_.scanSilence * period() <= kMissing * scan_period &&
                    old <= kMissing * scan_period + period();
  return sees ? Why::kDrives : Why::kScanMissing;
}

// When the position is certain again, the vehicle may be elsewhere on the path.
void PathDriver::check_deviation() {
  const auto& var = inputs_.position.var;
  const bool was_unsure = is_unsure_;
  is_unsure_ = cycle_.deviationMax > 0 && std::max(var.x, var.y) > cycle_.deviationMax;
  if (is_unsure_ || !was_unsure || inputs_.path.splines.empty()) return;
  if (state_ != pilot_state::kRunning && state_ != pilot_state::kPathError) return;
  follower_->take(inputs_.path.splines, at_);
  state_ = pilot_state::kRunning;
}

// Ends a HOLD of limited time.
void PathDriver::check_hold_time() {
  if (!is_held_ || hold_left_.count() == 0) return;
  hold_left_ -= std::min(hold_left_, period());
  if (hold_left_.count() == 0) is_held_ = false;
}

void PathDriver::check_watchdog() { watchdog_left_ -= std::min(watchdog_left_, period()); }

void PathDriver::check_refusal() {
  const bool is_refused = awaits_next_ && state_ == pilot_state::kPathError;
  refused_ = is_refused ? refused_ + period() : milliseconds(0);
}

// --- requests to other components: the next destination, a path around an obstacle

PathDriver::Request PathDriver::take_request() {
  const milliseconds patience(cycle_.replanTime);
  if (!destinations_.empty() && (reached_ || refused_ >= kAskNextAgain)) {
    awaits_next_ = true;
    reached_ = false;
    refused_ = milliseconds(0);
    state_ = pilot_state::kPlanning;
    return {.next = destinations_.front()};
  }
  if (patience.count() <= 0 || blocked_ < patience) return {};
  blocked_ = milliseconds(0);
  return {.around = replan_data()};
}

PathReplanData PathDriver::replan_data() const {
  const path::Beside& beside = follower_->beside();
  PathReplanData data;
  data.currSpline = static_cast<i32>(follower_->index());
  data.splinePos = {whole_millimetres(beside.along), whole_millimetres(beside.across),
                    static_cast<f32>(beside.turned)};
  data.distToObstacle = whole_millimetres(stop_->free_distance() + settings_.chassis.boundaryFront);
  data.pathLength = std::max(1, whole_millimetres(follower_->rest()));
  return data;
}

void PathDriver::hold(const PilotHoldData& command) {
  is_held_ = command.holdState != 0;
  hold_left_ = milliseconds(command.holdTime);
}

void PathDriver::watch(const PilotWatchdogData& command) {
  watchdog_ = watchdog_left_ = milliseconds(command.timeout);
}

u32 PathDriver::plan(u32 state) {
  reached_ = false;
  if (state == pilot_state::kPlanning) watchdog_ = milliseconds(0);
  return std::exchange(state_, state);
}

void PathDriver::keep(std::span<const DestinationPoint> further) {
  destinations_.assign(further.begin(), further.end());
  awaits_next_ = false;
}

// --- output

PilotStatusData PathDriver::status() const {
  PilotStatusData data{.recordingTime = cycle_.time, .pos = at_.position()};
  data.speed = static_cast<i32>(std::lround(command_.speed));
  data.curve = command_.speed == 0 ? 0 : static_cast<f32>(command_.omega / command_.speed);
  data.pilotState = state_;
  data.distanceToDest = -1;
  if (follower_ && !follower_->path().empty()) {
    data.distanceToDest = whole_millimetres(follower_->rest());
    const Position2d& end = follower_->path().back().endPos;
    data.dest = {.x = end.x, .y = end.y, .rho = end.rho};
  }
  if (reached_) data.distanceToDest = 0;
  return data;
}

void PathDriver::describe(PilotData& data) const {
  const PilotStatusData all = status();
  data.recordingTime = all.recordingTime;
  data.pos = all.pos;
  data.dest = all.dest;
  data.speed = all.speed;
  data.curve = all.curve;
  data.distanceToDest = all.distanceToDest;
  data.pilotState = all.pilotState;
  data.splines.clear();
  const auto path = follower_->path();
  if (path.empty()) return;
  const auto ahead = path.subspan(follower_->index());
  const auto shown = ahead.first(std::min(ahead.size(), kSplinesShown));
  data.splines.assign(shown.begin(), shown.end());
}

PathDriver::Why PathDriver::why() const {
  if (!located_) return Why::kNoPlace;
  if (follower_->state() == State::kNoPath) return Why::kNoPath;
  if (follower_->state() == State::kArrived) return Why::kArrived;
  if (follower_->state() == State::kAstray) return Why::kAstray;
  if (missing_ != Why::kDrives) return missing_;
  if (is_held_) return Why::kHeld;
  if (is_unwatched()) return Why::kUnwatched;
  const auto ahead = follower_->path().subspan(follower_->index());
  if (path::is_waiting(ahead.front())) return Why::kWaitsAside;
  if (safe_ <= static_cast<double>(settings_.chassis.vxMin)) return Why::kObstacle;
  if (path::is_waiting(ahead.back())) return Why::kMakesRoom;
  return command_.speed == 0 ? Why::kTurns : Why::kDrives;
}

std::string PathDriver::why_text() const {
  constexpr std::array<const char*, 16> kTexts = {
      "follows the path",
      "no position received yet",
      "the position is uncertain (deviationMax)",
      "no messages of the position",
      "no messages of the chassis",
      "no messages of the path",
      "no scans, or outdated ones",
      "an obstacle",
      "held by HOLD",
      "the program that monitors the drive is silent (WATCHDOG)",
      "no path",
      "arrived",
      "outside of the corridor",
      "a corner, or a change of direction",
      "drives aside to make room, since an obstacle blocks the path",
      "has made room, and waits until the path is clear",
  };
  const Why reason = why();
  std::string text = kTexts.at(static_cast<std::size_t>(reason));
  if (reason == Why::kObstacle)
    text += ", free distance " + std::to_string(whole_millimetres(stop_->free_distance())) + " mm";
  return text;
}

}  // namespace rack::pilot
