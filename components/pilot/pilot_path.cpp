// PilotPath: follows a path, and stops before obstacles.
#include <array>
#include <mutex>
#include <optional>
#include <utility>

#include "components/path/vehicle.h"
#include "components/pilot/obstacle_stop.h"
#include "components/pilot/path_follower.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"

namespace rack::pilot {
namespace {

using State = PathFollower::State;
using std::chrono::milliseconds;

constexpr int kSilence = 10;                // periods without a message of an input
constexpr int kMissing = 3;                 // messages of an input, then it stops
constexpr milliseconds kExtrapolated{500};  // at most: how old a position may be
constexpr std::size_t kSplinesShown = 10;
constexpr std::size_t kDestinationsMax = 1000;  // of a message
constexpr double kStands = 20;                  // mm/s

constexpr std::array<ParameterInfo, 14> kParameters = {{
    {"scan2dSys", 0, "system id of the scan", 0, kIdMax},
    {"scan2dInst", 0, "instance of the scan, -1: none, it stops before nothing", -1, kIdMax, true},
    {"chassisSys", 0, "system id of the chassis", 0, kIdMax},
    {"chassisInst", 0, "instance of the chassis", 0, kIdMax},
    {"positionSys", 0, "system id of the position", 0, kIdMax},
    {"positionInst", 0, "instance of the position", 0, kIdMax},
    {"pathSys", 0, "system id of the path", 0, kIdMax},
    {"pathInst", 0, "instance of the path", 0, kIdMax},
    {"maxSpeed", 4000, "mm/s", 1, 1e6},
    {"periodTime", 50, "ms", 10, 1000},
    {"lag", 100, "from a command to the wheels, ms", 0, 1000},
    {"deviationMax", 0,
     "it stops while the standard deviation of the position is larger, mm; 0: never", 0, 1e6},
    {"steeringRate", 0, "of steered wheels, deg/s; 0: they need no time", 0, 3600},
    {"replanTime", 3000,
     "how long it waits before an obstacle until it asks for another path, ms; 0: "
     "for ever",
     0, 3600000},
}};

constexpr ModuleInfo kInfo{
    .program = "PilotPath",
    .purpose = "Follows a path, and stops before obstacles.",
    .class_id = tims::class_id::kPilot,
    .parameters = kParameters,
    .command_body_max = body_max<PilotMultiDestData>(),
};

class PilotPath : public DataModule<PilotData> {
 public:
  PilotPath() : DataModule(kInfo, {.history = 5}) {
    reserve_all(scan_data_);
    reserve_all(path_data_);
    destinations_.reserve(kDestinationsMax);
  }

 private:
  Result<void> module_init() override {
    const auto box = [this](std::uint32_t slots, std::uint32_t size) {
      return create_mailbox(slots, size);
    };
    const auto work = box(10, body_max<PathData>());
    if (!work) return work.error();
    work_ = *work;
    const auto commands = box(4, 256);
    if (!commands) return commands.error();
    command_work_ = *commands;
    const auto scan = box(2, body_max<Scan2dData>());
    if (!scan) return scan.error();
    const auto position = box(10, wire_size<PositionData>());
    if (!position) return position.error();
    const auto chassis = box(10, wire_size<ChassisData>());
    if (!chassis) return chassis.error();
    const auto path = box(2, body_max<PathData>());
    if (!path) return path.error();
    scan_.emplace(*work_, **scan);
    position_.emplace(*work_, **position);
    chassis_.emplace(*work_, **chassis);
    path_.emplace(*work_, **path);
    return {};
  }

  // --- on and off

  Result<void> module_on() override {
    if (auto good = start_inputs(); !good) return good;
    const milliseconds own(integer("periodTime"));
    const milliseconds lag(integer("lag"));
    const milliseconds reaction = lag + own + (looks_ ? scan_period_ : milliseconds(0));
    const double fastest = std::min<double>(integer("maxSpeed"), limits_.vxMax);
    if (looks_) {
      if (auto good = check_braking(limits_, fastest, reaction); !good) return good;
    }
    if (path::turns_at_rest(limits_)) limits_.minTurningRadius = 0;
    set_period(own);
    begin({limits_, fastest, own, lag, radians(integer("steeringRate"))}, reaction);
    return DataModule::module_on();
  }

  void begin(const FollowerSettings& settings, milliseconds reaction) {
    const std::lock_guard lock(state_mutex_);
    follower_.emplace(settings);
    stop_.emplace(limits_, reaction);
    state_ = pilot_state::kIdle;
    destinations_.clear();
    blocked_ = hold_left_ = milliseconds(0);
    taken_ = 0;
    reached_ = false;
  }

  Result<void> start_inputs() {
    looks_ = integer("scan2dInst") >= 0;
    seen_ = located_ = is_unsure_ = false;
    const auto chassis = chassis_->start(address_of(tims::class_id::kChassis, "chassis"));
    if (!chassis) return chassis.error();
    const auto limits = chassis_->proxy().get_parameter();
    if (!limits) return limits.error();
    limits_ = *limits;
    chassis_period_ = *chassis;
    const auto position = position_->start(address_of(tims::class_id::kPosition, "position"));
    if (!position) return position.error();
    position_period_ = *position;
    const auto path = path_->start(address_of(tims::class_id::kPath, "path"));
    if (!path) return path.error();
    path_period_ = std::max(milliseconds(1), *path);
    if (!looks_) return {};
    const auto scan = scan_->start(address_of(tims::class_id::kScan2d, "scan2d"));
    if (!scan) return scan.error();
    scan_period_ = *scan;
    return {};
  }

  void module_off() override {
    if (chassis_->started()) (void)chassis_->proxy().move(0, 0, 0);
    chassis_->stop();
    position_->stop();
    path_->stop();
    scan_->stop();
  }

  // --- again and again

  Result<void> module_loop() override {
    sleep_until_next(period());
    if (auto good = look_at_all(); !good) return good;
    PathFollower::Command command;
    {
      const std::lock_guard lock(state_mutex_);
      const Pose at = pose_now();
      take_path(at);
      command = decide(at);
      describe(at, command);
    }
    auto moved = chassis_->proxy().move(static_cast<i32>(std::lround(command.speed)), 0,
                                        static_cast<f32>(command.omega));
    if (!moved) return moved;
    if (auto good = go_on(); !good) log().warning("%s", good.error().message());
    return put_local_buffer();
  }

  Result<void> look_at_all() {
    auto good = position_->newest(position_data_, kSilence);
    if (!good) return good.error();
    located_ = located_ || *good;
    good = chassis_->newest(chassis_data_, kSilence);
    if (!good) return good.error();
    const int path_silence = kSilence + static_cast<int>(kSilence * path_period_ / period());
    good = path_->newest(path_data_, path_silence);
    if (!good) return good.error();
    if (!looks_) return {};
    const int scan_silence = kSilence + static_cast<int>(kSilence * scan_period_ / period());
    good = scan_->newest(scan_data_, scan_silence);
    if (!good) return good.error();
    if (*good) {
      seen_ = true;
      seen_from_ = pose_at(scan_data_.recordingTime);
    }
    return {};
  }

  // Where it is by the newest position and how it moves.
  [[nodiscard]] Pose pose_at(TimeStamp time) const {
    const Pose pose = Pose::of(position_data_.pos);
    const auto old = std::clamp(time - position_data_.recordingTime, -kExtrapolated, kExtrapolated);
    const double seconds = std::chrono::duration<double>(old).count();
    return pose + Pose{.x = static_cast<double>(chassis_data_.vx) * seconds,
                       .y = static_cast<double>(chassis_data_.vy) * seconds,
                       .rho = static_cast<double>(chassis_data_.omega) * seconds};
  }
  [[nodiscard]] Pose pose_now() const { return pose_at(time_stamp()); }

  // A path is another one when its time is.
  void take_path(const Pose& at) {
    if (!located_ || path_data_.recordingTime == taken_) return;
    taken_ = path_data_.recordingTime;
    follower_->take(path_data_.splines, at);
    blocked_ = milliseconds(0);
    reached_ = false;
    if (path_data_.splines.empty()) {
      // The plan that was asked for has failed; else there is just none.
      if (state_ == pilot_state::kPlanning) state_ = pilot_state::kPathError;
      return;
    }
    state_ = pilot_state::kRunning;
  }

  // --- what it does

  PathFollower::Command decide(const Pose& at) {
    if (!located_) return {};
    mind_the_time();
    mind_the_deviation(at);
    const bool knows = knows_enough();
    const double safe = knows ? allowed(at) : 0;
    const auto command = follower_->follow(at, chassis_data_.vx, safe);
    const bool wants = follower_->state() == State::kRunning && !follower_->holds();
    const bool stands = std::abs(static_cast<double>(chassis_data_.vx)) < kStands;
    blocked_ = wants && knows && safe <= 0 && stands ? blocked_ + period() : milliseconds(0);
    if (follower_->state() == State::kAstray) state_ = pilot_state::kPathError;
    if (follower_->state() == State::kArrived && state_ == pilot_state::kRunning) {
      state_ = pilot_state::kIdle;
      reached_ = true;
    }
    return command;
  }

  // When messages are missing it does not know what is there, where it is, or where to go; it goes
  // on when they come again. And a position that nobody is sure of is none to steer by.
  [[nodiscard]] bool knows_enough() const {
    const auto is_missing = [&](int silence, milliseconds period_of_input) {
      return silence * period() >= kMissing * std::max(period_of_input, period());
    };
    if (is_unsure_ || is_missing(position_->silence(), position_period_) ||
        is_missing(chassis_->silence(), chassis_period_) ||
        is_missing(path_->silence(), path_period_))
      return false;
    if (!looks_) return true;
    const milliseconds old = time_stamp() - scan_data_.recordingTime;
    return seen_ && scan_->silence() * period() <= kMissing * scan_period_ &&
           old <= kMissing * scan_period_ + period();
  }

  // Once it is known again where it is, that may be elsewhere on the path.
  void mind_the_deviation(const Pose& at) {
    const i32 most = integer("deviationMax");
    const bool was_unsure = is_unsure_;
    is_unsure_ = most > 0 && std::max(position_data_.var.x, position_data_.var.y) > most;
    if (is_unsure_ && !was_unsure) log().warning("It stops: nobody is sure where it is");
    if (is_unsure_ || !was_unsure || path_data_.splines.empty()) return;
    log().print("It is known again where it is");
    if (state_ != pilot_state::kRunning && state_ != pilot_state::kPathError) return;
    follower_->take(path_data_.splines, at);
    state_ = pilot_state::kRunning;
  }

  double allowed(const Pose& at) {
    if (!looks_) return limits_.vxMax;
    return stop_->speed_max(scan_data_, seen_from_, at, *follower_);
  }

  // Of HOLD, as far as it has an end.
  void mind_the_time() {
    if (!follower_->holds() || hold_left_.count() == 0) return;
    hold_left_ -= std::min(hold_left_, period());
    if (hold_left_.count() == 0) follower_->hold(false);
  }

  // What needs others: the next destination, a way round an obstacle.
  Result<void> go_on() {
    DestinationPoint next;
    PathReplanData around;
    {
      const std::lock_guard lock(state_mutex_);
      const milliseconds patience(integer("replanTime"));
      if (reached_ && !destinations_.empty()) {
        next = destinations_.front();
        destinations_.erase(destinations_.begin());
        reached_ = false;
        state_ = pilot_state::kPlanning;
      } else if (patience.count() > 0 && blocked_ >= patience) {
        blocked_ = milliseconds(0);
        around = where_it_is();
      } else {
        return {};
      }
    }
    if (around.pathLength > 0) return path_->proxy().replan(around);
    return path_->proxy().set_destination(destination_of(next.pos, next.speed));
  }

  [[nodiscard]] PathReplanData where_it_is() const {
    const path::Beside& beside = follower_->beside();
    PathReplanData data;
    data.currSpline = static_cast<i32>(follower_->index());
    data.splinePos = {whole_millimetres(beside.along), whole_millimetres(beside.across),
                      static_cast<f32>(beside.turned)};
    data.distToObstacle = whole_millimetres(stop_->free_way() + limits_.boundaryFront);
    data.pathLength = std::max(1, whole_millimetres(follower_->rest()));
    return data;
  }

  static PathDestData destination_of(const Position3d& pos, i32 speed) {
    return {.pos = {pos.x, pos.y, pos.rho}, .speed = speed};
  }

  void describe(const Pose& at, const PathFollower::Command& command) {
    PilotData& data = get_local_buffer();
    data.recordingTime = time_stamp();
    data.pos = at.position();
    data.speed = static_cast<i32>(std::lround(command.speed));
    data.curve = command.speed == 0 ? 0 : static_cast<f32>(command.omega / command.speed);
    data.pilotState = state_;
    const auto path = follower_->path();
    data.distanceToDest = path.empty() ? -1 : whole_millimetres(follower_->rest());
    if (reached_) data.distanceToDest = 0;
    data.splines.clear();
    data.dest = {};
    if (!path.empty()) {
      const Position2d& end = path.back().endPos;
      data.dest = {.x = end.x, .y = end.y, .rho = end.rho};
      const auto ahead = path.subspan(follower_->index());
      const auto shown = ahead.first(std::min(ahead.size(), kSplinesShown));
      data.splines.assign(shown.begin(), shown.end());
    }
    status_ = {data.recordingTime,  data.pos,       data.dest, data.speed, data.curve,
               data.distanceToDest, data.pilotState};
  }

  // --- commands

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PilotType::kSetDestination:
        return answered(message, set_destination(message));
      case PilotType::kSetMultiDestination:
        return answered(message, set_destinations(message));
      case PilotType::kHoldCommand:
        return answered(message, hold(message));
      case PilotType::kRevertCommand:
        return answered(message, revert(message));
      case PilotType::kGetStatus: {
        const std::lock_guard lock(state_mutex_);
        reply(message.header, PilotType::kStatus, status_);
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  // The path plans; what it says against it is the answer. Its plan may come before that.
  Result<void> go_to(const Position3d& pos, i32 speed) {
    if (!is_on()) return refused("turn it on first");
    const u32 before = begin_planning(pilot_state::kPlanning);
    PathProxy path(*command_work_, address_of(tims::class_id::kPath, "path"));
    auto good = path.set_destination(destination_of(pos, speed));
    if (!good) begin_planning(before);
    return good;
  }

  u32 begin_planning(u32 state) {
    const std::lock_guard lock(state_mutex_);
    reached_ = false;
    return std::exchange(state_, state);
  }

  Result<void> set_destination(const tims::MessageView& message) {
    const auto wish = decode<PilotDestData>(message);
    if (!wish) return wish.error();
    {
      const std::lock_guard lock(state_mutex_);
      destinations_.clear();
    }
    return go_to(wish->pos, wish->speed);
  }

  Result<void> set_destinations(const tims::MessageView& message) {
    const auto wish = decode<PilotMultiDestData>(message);
    if (!wish) return wish.error();
    if (wish->points.empty()) return refused("no destination is among them");
    if (auto good = go_to(wish->points.front().pos, wish->points.front().speed); !good) return good;
    const std::lock_guard lock(state_mutex_);
    destinations_.assign(wish->points.begin() + 1, wish->points.end());
    return {};
  }

  Result<void> hold(const tims::MessageView& message) {
    const auto wish = decode<PilotHoldData>(message);
    if (!wish) return wish.error();
    const std::lock_guard lock(state_mutex_);
    if (!follower_) return refused("turn it on first");
    follower_->hold(wish->holdState != 0);
    hold_left_ = milliseconds(wish->holdTime);
    return {};
  }

  Result<void> revert(const tims::MessageView& message) {
    const auto wish = decode<PilotRevertData>(message);
    if (!wish) return wish.error();
    const std::lock_guard lock(state_mutex_);
    if (!follower_ || !is_on()) return refused("turn it on first");
    follower_->revert(milliseconds(wish->revertTime));
    return {};
  }

  tims::Mailbox* work_ = nullptr;
  tims::Mailbox* command_work_ = nullptr;  // of the command task
  std::optional<Input<Scan2dProxy>> scan_;
  std::optional<Input<PositionProxy>> position_;
  std::optional<Input<ChassisProxy>> chassis_;
  std::optional<Input<PathProxy>> path_;
  ChassisParamData limits_;
  Scan2dData scan_data_;
  PositionData position_data_;
  ChassisData chassis_data_;
  PathData path_data_;
  milliseconds scan_period_{0};
  milliseconds path_period_{50};
  milliseconds position_period_{0};
  milliseconds chassis_period_{0};
  Pose seen_from_;
  bool looks_ = false;
  bool seen_ = false;
  bool located_ = false;
  bool is_unsure_ = false;  // of where it is

  PriorityMutex state_mutex_;  // of what follows
  std::optional<PathFollower> follower_;
  std::optional<ObstacleStop> stop_;
  u32 state_ = pilot_state::kIdle;
  bool reached_ = false;                        // the end of its path
  TimeStamp taken_ = 0;                         // of its path
  std::vector<DestinationPoint> destinations_;  // further ones
  milliseconds hold_left_{0};
  milliseconds blocked_{0};
  PilotStatusData status_;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotPath pilot;
  return pilot.run(argc, argv);
}
