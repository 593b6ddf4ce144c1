#include "tools/evaluation/drives/robot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "components/localisation/mcl_messages.h"
#include "components/path/vehicle.h"

namespace rack::drives {
namespace {

using namespace std::chrono_literals;
using pilot::PathCycle;

constexpr tims::Duration kMovementEvery = 100ms;
constexpr tims::Duration kScanEvery = 215ms;
constexpr tims::Duration kScanTakes = 100ms;  // from its middle until it is received
constexpr tims::Duration kPathEvery = 50ms;
constexpr tims::Duration kPilotEvery = 50ms;
constexpr tims::Duration kMclEvery = 1s;
constexpr tims::Duration kChassisDelay = 60ms;  // from MOVE to the reaction of the wheels
constexpr tims::Duration kMoveValid = 150ms;    // three periods of the pilot
constexpr f32 kLooksAround = 0.4F;              // rad/s, of a robot that does not know where it is
constexpr double kStartDeviation = 500;         // mm
constexpr double kDeviationTurn = radians(0.03);  // per mm
constexpr int kFirstStamp = 1000;                 // ms: 0 is no time
constexpr int kRays = 181;
constexpr std::size_t kHistory = 1000;

template <typename Data>
void remember(std::map<u32, Data>& history, const Data& data) {
  history[data.recordingTime.raw()] = data;
  if (history.size() > kHistory) history.erase(history.begin());
}

// As the components answer GET_DATA with a time.
template <typename Data>
std::optional<Data> at_time(const std::map<u32, Data>& history, TimeStamp time,
                            std::chrono::milliseconds ahead) {
  const auto after = history.upper_bound(time.raw());
  if (history.empty() || after == history.begin()) return std::nullopt;
  const Data& before = std::prev(after)->second;
  if (after != history.end()) return navigation::interpolated(before, after->second, time);
  if (time - before.recordingTime > ahead) return std::nullopt;
  if (history.size() < 2 || time == before.recordingTime) return before;
  return navigation::interpolated(std::prev(after, 2)->second, before, time);
}

}  // namespace

Robot::Robot(world::World& world, const RobotSettings& settings,
             const localisation::LikelihoodField& field, const localisation::WallLines& walls,
             const path::FreeSpace& space, const Load& load)
    : world_(world),
      settings_(settings),
      field_(field),
      walls_(walls),
      space_(space),
      machine_(load, settings.seed),
      now_(world.now()),
      begin_(now_),
      next_movement_(now_),
      next_scan_(now_),
      rims_(world.wheels(settings.robot).motors()),
      odometry_in_(navigation::DeadReckoning::kDataWaiting),
      position_in_(4),
      mcl_in_(2) {
  reckoning_.emplace(Pose{});
  begin_mcl({}, kStartDeviation);
  if (settings_.starts_anywhere) localiser_->start_anywhere();
  begin_path();
  begin_pilot();
}

tims::Time Robot::time_of(TimeStamp stamp) const {
  return begin_ + std::chrono::milliseconds(stamp.raw()) - std::chrono::milliseconds(kFirstStamp);
}

TimeStamp Robot::stamp() const {
  return static_cast<u32>(
      kFirstStamp + std::chrono::duration_cast<std::chrono::milliseconds>(now_ - begin_).count());
}

void Robot::note(std::string_view text) {
  const double seconds = std::chrono::duration<double>(now_ - begin_).count();
  log_.push_back(fmt::format("{:7.2f} s  {}", seconds, text));
}

void Robot::step() {
  machine_.advance(now_, kStep);
  restart_crashed();
  if (now_ >= next_movement_) measure_movement();
  if (now_ >= next_scan_) measure_scan();
  run_chassis();
  run_scan2d();
  run_odometry();
  run_position();
  run_mcl();
  run_path();
  run_pilot();
  now_ += kStep;
  world_.advance(now_);
}

// --- the devices

void Robot::measure_movement() {
  next_movement_ += kMovementEvery;
  const auto motors = world_.motors(settings_.robot);
  std::vector<double> turned(rims_.size());
  for (std::size_t i = 0; i < rims_.size(); ++i)
    turned[i] = motors[i].position - std::exchange(rims_[i], motors[i].position);
  const device::ChassisSpeed moved = world_.wheels(settings_.robot).movement(turned);
  const float seconds = std::chrono::duration<float>(kMovementEvery).count();
  ChassisData data{.recordingTime = stamp()};
  data.deltaX = moved.vx;
  data.deltaY = moved.vy;
  data.deltaRho = moved.omega;
  data.vx = moved.vx / seconds;
  data.vy = moved.vy / seconds;
  data.omega = moved.omega / seconds;
  encoders_.put(data);
}

void Robot::measure_scan() {
  next_scan_ += kScanEvery;
  Scan2dData scan{.recordingTime = stamp()};
  const world::SensorDescription& scanner =
      world_.description().robots[settings_.robot].sensors[settings_.scanner.sensor];
  for (int i = 0; i < kRays; ++i) {
    const double angle = radians(i - 90.0);
    const world::Echo echo = world_.measure(settings_.scanner, {.azimuth = angle}, now_);
    ScanPoint point;
    const Pose at =
        scanner.mount + Pose{.x = echo.range * std::cos(angle), .y = echo.range * std::sin(angle)};
    point.x = whole_millimetres(at.x);
    point.y = whole_millimetres(at.y);
    point.z = whole_millimetres(echo.range);
    if (!echo.is_valid) point.type = scan_point::kInvalid;
    scan.points.push_back(point);
  }
  turns_.put({now_ + kScanTakes, std::move(scan)});
}

void Robot::command(const ChassisMoveData& move) {
  commanded_ = now_;
  world_.drive(settings_.robot, device::within_limits(move, settings_.chassis),
               now_ + kChassisDelay);
}

// --- their drivers

void Robot::run_chassis() {
  if (commanded_ != tims::Time{} && now_ - commanded_ > kMoveValid) {
    commanded_ = {};
    world_.drive(settings_.robot, device::ChassisSpeed{}, now_ + kChassisDelay);
  }
  if (!machine_.runs(Program::kChassis, now_)) return;
  while (const auto data = encoders_.take()) {
    if (!machine_.loses()) odometry_in_.put(*data);
    pilot_chassis_in_.put(*data);
  }
}

void Robot::run_scan2d() {
  if (!machine_.runs(Program::kScan2d, now_)) return;
  std::vector<std::pair<tims::Time, Scan2dData>> later;
  while (auto scan = turns_.take()) {
    if (scan->first > now_) {
      later.push_back(std::move(*scan));
      continue;
    }
    if (!machine_.loses()) mcl_in_.put(scan->second);
    path_scan_in_.put(scan->second);
    pilot_scan_in_.put(scan->second);
  }
  for (const auto& scan : later) turns_.put(scan);
}

// --- odometry, position, localisation

void Robot::run_odometry() {
  if (!machine_.runs(Program::kOdometry, now_)) return;
  while (const auto movement = odometry_in_.take()) {
    const OdometryData data = reckoning_->add(*movement);
    remember(odometry_, data);
    position_in_.put(data);
  }
}

std::optional<OdometryData> Robot::odometry_at(TimeStamp time) const {
  if (!machine_.runs(Program::kOdometry, now_)) return std::nullopt;
  return at_time(odometry_, time, std::chrono::milliseconds(100));
}

void Robot::run_position() {
  if (!machine_.runs(Program::kPosition, now_)) return;
  while (const auto data = position_in_.take()) {
    if (!std::exchange(tracks_, true)) {
      tracker_.expect(navigation::PositionTracker::kUnknown);
      tracker_.begin({}, {}, *data);
    }
    const PositionData position = tracker_.follow(*data);
    newest_position_ = position;
    remember(positions_, position);
    path_position_in_.put(position);
    pilot_position_in_.put(position);
  }
}

std::optional<PositionData> Robot::position_at(TimeStamp time) const {
  if (!machine_.runs(Program::kPosition, now_)) return std::nullopt;
  return at_time(positions_, time, 1h);
}

void Robot::begin_mcl(const Pose& at, double deviation) {
  localisation::LocaliserSettings settings;
  settings.filter = settings_.filter;
  localiser_.emplace(settings, settings_.seed);
  localiser_->start_at(at, deviation, deviation * kDeviationTurn);
  updates_ = {};
}

// As with startMode 2: where Position was at the time of the first scan.
bool Robot::restart_mcl(TimeStamp time, const Pose& odometry) {
  const auto position = position_at(time);
  if (!position) return false;
  begin_mcl(Pose::of(position->pos), kStartDeviation);
  if ((settings_.starts_anywhere && !is_localised()) ||
      !localisation::PositionUpdates::may_start_at(*position, odometry, kStartDeviation,
                                                   kStartDeviation * kDeviationTurn))
    localiser_->start_anywhere();
  mcl_starts_ = false;
  return true;
}

void Robot::run_mcl() {
  if (!machine_.runs(Program::kMcl, now_)) return;
  while (const auto scan = mcl_in_.take()) {
    const auto odometry = odometry_at(scan->recordingTime);
    if (!odometry) continue;
    if (mcl_starts_ && !restart_mcl(scan->recordingTime, Pose::of(odometry->pos))) continue;
    mcl_odometry_ = Pose::of(odometry->pos);
    localisation::beams_of(*scan, settings_.range_max, beams_);
    localiser_->take(field_, mcl_odometry_, beams_, &walls_);
    if (now_ - published_ < kMclEvery) continue;
    published_ = now_;
    const auto step = updates_.take(*localiser_, mcl_odometry_, position_at(scan->recordingTime),
                                    scan->recordingTime,
                                    [&](TimeStamp time) { return position_at(time).has_value(); });
    using Event = localisation::PositionUpdates::Event;
    if (step.event == Event::kCertain) note("Mcl: the pose is certain");
    if (step.event == Event::kUncertain) note("Mcl: the pose is uncertain");
    if (step.event == Event::kFollows) note("Mcl: follows Position");
    if (!step.update || !machine_.runs(Program::kPosition, now_)) continue;
    if (const auto then = odometry_at(step.update->recordingTime))
      tracker_.update(*step.update, *then);
  }
}

bool Robot::is_localised() const {
  return newest_position_ && std::max(newest_position_->var.x.raw(),
                                      newest_position_->var.y.raw()) <= settings_.deviation_max;
}

// --- path and pilot

void Robot::begin_path() {
  path::RouteSettings settings{.chassis = settings_.chassis,
                               .limits = path::limits_of(settings_.chassis)};
  settings.limits.corridor = std::max(500.0, settings.limits.half_width + 100);
  if (auto good = planner_.begin(settings, {space_}); !good) note(good.error().detail());
  (void)planner_.begin_route();
}

void Robot::run_path() {
  if (now_ < next_path_ || !machine_.runs(Program::kPath, now_)) return;
  next_path_ = std::max(next_path_ + kPathEvery, now_);
  if (const auto position = path_position_in_.take_newest())
    planner_.take_position(Pose::of(position->pos));
  if (const auto scan = path_scan_in_.take_newest()) planner_.take_scan(*scan);
  while (const auto from = replans_.take()) {
    const auto done = planner_.replan(*from);
    note("Path: plans again" + (done ? std::string() : ": " + done.error().detail()));
  }
  if (const auto failure = planner_.step(stamp(), path_)) note("Path: no plan: " + *failure);
  if (const bool before = std::exchange(makes_room_, planner_.makes_room()); makes_room_ != before)
    note(makes_room_ ? "Path: makes room" : "Path: there is a path again");
  pilot_path_in_.put(path_);
}

void Robot::begin_pilot() {
  pilot::PathDriverSettings settings{.chassis = settings_.chassis,
                                     .maxSpeed = settings_.speed_max,
                                     .periodTime = 50,
                                     .scanPeriod = 215,
                                     .positionPeriod = 100,
                                     .chassisPeriod = 100,
                                     .pathPeriod = 50};
  if (auto good = driver_.begin(settings); !good) note(good.error().detail());
  cycle_ = {.deviationMax = settings_.deviation_max, .replanTime = settings_.replan_time};
}

void Robot::run_pilot() {
  if (now_ < next_pilot_ || !machine_.runs(Program::kPilot, now_)) return;
  next_pilot_ = std::max(next_pilot_ + kPilotEvery, now_);
  pilot::PathDriver::Inputs& inputs = driver_.inputs();
  cycle_.time = stamp();
  cycle_.came = 0;
  const auto take = [&](auto& mailbox, auto& data, u32 bit, i32& silence) {
    auto newest = mailbox.take_newest();
    silence = newest ? 0 : silence + 1;
    if (!newest) return;
    data = std::move(*newest);
    cycle_.came |= bit;
  };
  take(pilot_chassis_in_, inputs.chassis, PathCycle::kChassis, cycle_.chassisSilence);
  take(pilot_position_in_, inputs.position, PathCycle::kPosition, cycle_.positionSilence);
  take(pilot_path_in_, inputs.path, PathCycle::kPath, cycle_.pathSilence);
  take(pilot_scan_in_, inputs.scan, PathCycle::kScan, cycle_.scanSilence);
  ChassisMoveData move = driver_.step(cycle_);
  // As an operator does: at rest, each scan repeats the same measurement.
  if (settings_.starts_anywhere && !has_goal_ && !is_localised()) move.omega = kLooksAround;
  if (machine_.runs(Program::kChassis, now_)) command(move);
  const auto request = driver_.take_request();
  if (request.around) replans_.put(*request.around);
}

tims::Result<void> Robot::send(const Pose& goal) {
  const u32 before = driver_.plan(pilot_state::kPlanning);
  const Position3d at = goal.position();
  auto good = planner_.set_destination({.pos = {at.x, at.y, at.rho}, .speed = 0}, {});
  if (!good) driver_.plan(before);
  has_goal_ = good.ok();
  return good;
}

// --- restarts; the supervisor reports to OdometryChassis where it was

void Robot::restart_crashed() {
  if (machine_.take_crash(Program::kOdometry)) {
    note("OdometryChassis restarts");
    const Pose at = odometry_.empty() ? Pose{} : Pose::of(odometry_.rbegin()->second.pos);
    reckoning_.emplace(at);
    odometry_.clear();
    odometry_in_.clear();
  }
  if (machine_.take_crash(Program::kPosition)) {
    note("Position restarts");
    tracker_ = navigation::PositionTracker{{}, {}};
    tracks_ = false;
    positions_.clear();
    position_in_.clear();
  }
  if (machine_.take_crash(Program::kMcl)) {
    note("Mcl restarts");
    mcl_in_.clear();
    mcl_starts_ = true;
  }
  if (machine_.take_crash(Program::kPilot)) {
    note("PilotPath restarts");
    begin_pilot();
  }
  if (machine_.take_crash(Program::kPath)) note("PathRDDF restarts");
  if (machine_.take_crash(Program::kChassis)) note("the chassis restarts");
  if (machine_.take_crash(Program::kScan2d)) note("Scan2d restarts");
}

}  // namespace rack::drives
