// PilotPath: follows a path and stops at obstacles. While position, path or scans are missing, it
// stands and subscribes again; it keeps its destination.
#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "components/files/capture_file.h"
#include "components/pilot/path_driver.h"
#include "components/pilot/pilot_replay.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"

namespace rack::pilot {
namespace {

using std::chrono::milliseconds;

constexpr int kSilence = 10;  // periods without a message from an input
constexpr int kSilenceMost = 1000000;
constexpr milliseconds kAskAgain{1000};
constexpr milliseconds kAskFor{50};  // short: the vehicle stands during this time

constexpr std::array<ParameterInfo, 11> kParameters = {{
    or_none(required_partner("scan2d", "the scan", "the scan; -1: no scan, no stop at obstacles")),
    partner("chassis", "the chassis"),
    partner("position", "the position"),
    partner("path", "the path"),
    {"maxSpeed", 4000, "maximum speed [mm/s]", 1, 1e6},
    {"periodTime", 50, "period of the decisions [ms]", 10, 1000},
    {"lag", 100, "delay from a command to the reaction of the wheels [ms]", 0, 1000},
    {"deviationMax", 0,
     "stop while the standard deviation of the position is larger [mm]; 0: never", 0, 1e6},
    {"steeringRate", 0, "rate of steered wheels [deg/s]; 0: no limit", 0, 3600},
    {"replanTime", 3000,
     "time to wait at an obstacle before another path is requested [ms]; 0: never", 0, 3600000},
    host_file({"record", "", "file to record inputs and decisions to, for pilot-replay"}),
}};

constexpr ModuleInfo kInfo{
    .program = "PilotPath",
    .purpose = "Follows a path and stops at obstacles.",
    .class_id = tims::class_id::kPilot,
    .parameters = kParameters,
    .command_body_max = body_max<PilotMultiDestData>(),
};

class PilotPath : public DataModule<PilotData> {
 public:
  PilotPath() : DataModule(kInfo, {.history = 5}) {
    bytes_.resize(std::max(body_max<PathData>(), body_max<Scan2dData>()));
  }

 private:
  // --- on and off

  Result<void> module_on() override {
    PathDriverSettings settings{.maxSpeed = integer("maxSpeed"),
                                .periodTime = integer("periodTime"),
                                .lag = integer("lag"),
                                .steeringRate = integer("steeringRate")};
    if (auto good = start_inputs(settings); !good) return good;
    set_period(milliseconds(settings.periodTime));
    path_.patience = kSilence + kSilence * settings.pathPeriod / settings.periodTime;
    scan_.patience = kSilence + kSilence * settings.scanPeriod / settings.periodTime;
    request_path_.connect();
    if (auto good = begin(settings); !good) return good;
    return DataModule::module_on();
  }

  Result<void> begin(const PathDriverSettings& settings) {
    std::unique_ptr<device::CaptureFile> capture;
    if (const std::string& path = text("record"); !path.empty()) {
      auto created = device::CaptureFile::create(path, kInfo.program, now());
      if (!created) return created.error();
      capture = std::move(*created);
    }
    const std::lock_guard lock(state_mutex_);
    if (auto good = driver_.begin(settings); !good) return good;
    capture_ = std::move(capture);
    records_ = 0;
    recorded_path_.reset();
    record(PilotRecord::kBegin, settings);
    return {};
  }

  // An input that may be missing for some time.
  template <typename ProxyType>
  struct Feed {
    Input<ProxyType> input;
    int patience = kSilence;            // periods without a message until it counts as lost
    int left = 0;                       // periods left of it
    int silence = 0;                    // periods since the last message
    std::optional<tims::Time> asked{};  // last attempt to subscribe again, while it is lost
  };

  Result<void> start_inputs(PathDriverSettings& settings) {
    const auto chassis = chassis_.start();
    if (!chassis) return chassis.error();
    const auto limits = chassis_->get_parameter();
    if (!limits) return limits.error();
    settings.chassis = *limits;
    settings.chassisPeriod = milliseconds_of(*chassis);
    const auto position = begin_feed(position_);
    if (!position) return position.error();
    settings.positionPeriod = milliseconds_of(*position);
    const auto path = begin_feed(path_);
    if (!path) return path.error();
    settings.pathPeriod = milliseconds_of(*path);
    const auto scan = begin_feed(scan_);
    if (!scan) return scan.error();
    settings.looks = scan_.input ? 1 : 0;
    settings.scanPeriod = milliseconds_of(*scan);
    return {};
  }
  template <typename ProxyType>
  static Result<milliseconds> begin_feed(Feed<ProxyType>& feed) {
    feed.silence = 0;
    feed.left = kSilence;
    feed.asked.reset();
    return feed.input.start();
  }
  static i32 milliseconds_of(milliseconds time) { return static_cast<i32>(time.count()); }

  void module_off() override {
    if (chassis_) (void)chassis_->move(0, 0, 0);
    chassis_.stop();
    position_.input.stop();
    path_.input.stop();
    scan_.input.stop();
    finish_recording();
  }

  // --- one period

  Result<void> module_loop() override {
    sleep_until_next(period());
    PathCycle cycle{.deviationMax = integer("deviationMax"), .replanTime = integer("replanTime")};
    if (auto good = read_inputs(cycle); !good) return good;
    ChassisMoveData move;
    PathDriver::Request request;
    {
      const std::lock_guard lock(state_mutex_);
      move = decide(cycle);
      driver_.describe(get_local_buffer());
      request = driver_.take_request();
    }
    auto moved = chassis_->move(move.vx, move.vy, move.omega);
    if (!moved) return moved;
    report_refusal(request_path_->take_answer());
    if (auto sent = forward(request); !sent) report_refusal(sent);
    return put_local_buffer();
  }

  // With state_mutex_ locked: the recording has each command either before or after this decision.
  ChassisMoveData decide(PathCycle& cycle) {
    const bool was_unsure = driver_.is_unsure();
    cycle.time = time_stamp();
    record_inputs(cycle);
    const ChassisMoveData move = driver_.step(cycle);
    record(PilotRecord::kMove, move);
    record(PilotRecord::kStatus, driver_.status());
    report_recording();
    if (driver_.is_unsure() != was_unsure) {
      if (was_unsure)
        log().print("the position is certain again");
      else
        log().warning("stops: the position is uncertain (deviationMax)");
    }
    return move;
  }

  Result<void> read_inputs(PathCycle& cycle) {
    PathDriver::Inputs& inputs = driver_.inputs();
    const auto come = chassis_.newest(inputs.chassis, kSilence);
    if (!come) return come.error();
    if (*come) cycle.came |= PathCycle::kChassis;
    cycle.chassisSilence = chassis_.silence();
    if (take(position_, inputs.position)) cycle.came |= PathCycle::kPosition;
    if (take(path_, inputs.path)) cycle.came |= PathCycle::kPath;
    cycle.positionSilence = position_.silence;
    cycle.pathSilence = path_.silence;
    if (!scan_.input) return {};
    if (take(scan_, inputs.scan)) cycle.came |= PathCycle::kScan;
    cycle.scanSilence = scan_.silence;
    return {};
  }

  template <typename ProxyType>
  bool take(Feed<ProxyType>& feed, typename ProxyType::Data& data) {
    const auto come = feed.asked ? Result<bool>(false) : feed.input.newest(data);
    if (come && *come) {
      feed.silence = 0;
      feed.left = feed.patience;
      return true;
    }
    feed.silence = std::min(feed.silence + 1, kSilenceMost);
    if (feed.asked) {
      ask_again(feed);
    } else if (!come || --feed.left <= 0) {
      log().warning("{}: stands until data arrive again",
                    come ? "no data from " + name_of(feed) : std::string(come.error().message()));
      feed.asked = now();
    }
    return false;
  }

  template <typename ProxyType>
  void ask_again(Feed<ProxyType>& feed) {
    if (now() - *feed.asked < kAskAgain) return;
    feed.asked = now();
    if (!feed.input.start_again({.on = kAskFor, .off = kAskFor, .data = kAskFor})) return;
    feed.asked.reset();
    feed.left = feed.patience;
    log().print("{} sends data again", name_of(feed));
  }

  template <typename ProxyType>
  std::string name_of(Feed<ProxyType>& feed) {
    return feed.input->component().to_string(address_widths());
  }

  // --- requests to other components

  // Planning takes time: the answer is read in a later period.
  Result<void> forward(const PathDriver::Request& request) {
    if (!request.around && !request.next) return {};
    {
      const std::lock_guard lock(state_mutex_);
      asks_next_ = request.next.has_value();
    }
    if (request.around) return request_path_->post_replan(*request.around);
    return request_path_->post_destination(destination_of(request.next->pos, request.next->speed));
  }
  void report_refusal(const std::optional<Result<void>>& done) {
    if (!done) return;
    const std::lock_guard lock(state_mutex_);
    const bool is_of_next = std::exchange(asks_next_, false);
    if (*done) return;
    log().warning("{}", done->error().message());
    if (is_of_next) plan(pilot_state::kPathError);
  }

  static PathDestData destination_of(const Position3d& pos, i32 speed) {
    return {.pos = {pos.x, pos.y, pos.rho}, .speed = speed};
  }

  // --- the recording; under state_mutex_

  template <typename T>
  void record(PilotRecord kind, const T& message) {
    if (!capture_) return;
    const auto size = encode(message, std::span(bytes_), std::endian::little);
    if (!size) return;
    const bool is_output = kind == PilotRecord::kMove || kind == PilotRecord::kStatus;
    capture_->add(now(), is_output ? device::Direction::kSent : device::Direction::kReceived,
                  static_cast<std::uint32_t>(kind), std::span(bytes_).first(*size));
    ++records_;
  }

  // Records the path only when it has changed: it is long and is sent repeatedly.
  void record_inputs(const PathCycle& cycle) {
    if (!capture_) return;
    const PathDriver::Inputs& inputs = driver_.inputs();
    if ((cycle.came & PathCycle::kPosition) != 0) record(PilotRecord::kPosition, inputs.position);
    if ((cycle.came & PathCycle::kChassis) != 0) record(PilotRecord::kChassis, inputs.chassis);
    if ((cycle.came & PathCycle::kPath) != 0 && inputs.path.recordingTime != recorded_path_) {
      recorded_path_ = inputs.path.recordingTime;
      record(PilotRecord::kPath, inputs.path);
    }
    if ((cycle.came & PathCycle::kScan) != 0) record(PilotRecord::kScan, inputs.scan);
    record(PilotRecord::kCycle, RecordedCycle{cycle, records_});
  }

  void report_recording() {
    if (!capture_) return;
    if (const auto event = capture_->take_event()) log().warning("{}", *event);
  }

  void finish_recording() {
    const std::lock_guard lock(state_mutex_);
    if (capture_) capture_->finish();
    report_recording();
    capture_.reset();
  }

  // --- commands

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PilotType::kSetDestination:
        return set_destination(message);
      case PilotType::kSetMultiDestination:
        return set_destinations(message);
      case PilotType::kHoldCommand:
        return answered(message, hold(message));
      case PilotType::kRevertCommand:
        return answered(message, revert(message));
      case PilotType::kWatchdog:
        return answered(message, watch(message));
      case PilotType::kGetStatus: {
        const std::lock_guard lock(state_mutex_);
        reply(message.header, PilotType::kStatus, driver_.status());
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  // By the worker, since planning takes time: forwards the destination to the path component, whose
  // reply becomes the answer. The new plan may arrive before the reply.
  Result<void> go_to(const Position3d& pos, i32 speed) {
    if (!is_on()) return refused("the pilot is off; turn it on first");
    const u32 before = begin_planning();
    command_path_.connect();
    auto good = command_path_->set_destination(destination_of(pos, speed));
    if (!good) end_planning(before);
    return good;
  }

  u32 begin_planning() {
    const std::lock_guard lock(state_mutex_);
    asks_next_ = false;
    return plan(pilot_state::kPlanning);
  }
  // The pilot may have been turned off and on in between.
  void end_planning(u32 before) {
    const std::lock_guard lock(state_mutex_);
    asks_next_ = false;
    if (driver_.status().pilotState == pilot_state::kPlanning) plan(before);
  }
  u32 plan(u32 state) {
    record(PilotRecord::kPlan, PilotPlan{state});
    return driver_.plan(state);
  }

  void keep(const PilotMultiDestData& further) {
    const std::lock_guard lock(state_mutex_);
    record(PilotRecord::kKeep, further);
    driver_.keep(further.points);
  }

  Result<void> set_destination(const tims::MessageView& message) {
    const auto command = decode<PilotDestData>(message);
    if (!command) return command.error();
    return answered_later(message, [this, to = *command] {
      keep({});
      return go_to(to.pos, to.speed);
    });
  }

  Result<void> set_destinations(const tims::MessageView& message) {
    const auto command = decode<PilotMultiDestData>(message);
    if (!command) return command.error();
    if (command->points.empty()) return refused("the list of destinations is empty");
    return answered_later(message, [this, list = *command]() mutable -> Result<void> {
      const DestinationPoint first = list.points.front();
      if (auto good = go_to(first.pos, first.speed); !good) return good;
      list.points.erase(list.points.begin());
      keep(list);
      return {};
    });
  }

  Result<void> hold(const tims::MessageView& message) {
    const auto command = decode<PilotHoldData>(message);
    if (!command) return command.error();
    const std::lock_guard lock(state_mutex_);
    if (!driver_.has_begun()) return refused("the pilot is off; turn it on first");
    record(PilotRecord::kHold, *command);
    driver_.hold(*command);
    return {};
  }

  Result<void> watch(const tims::MessageView& message) {
    const auto command = decode<PilotWatchdogData>(message);
    if (!command) return command.error();
    const std::lock_guard lock(state_mutex_);
    if (!driver_.has_begun()) return refused("the pilot is off; turn it on first");
    record(PilotRecord::kWatchdog, *command);
    driver_.watch(*command);
    return {};
  }

  Result<void> revert(const tims::MessageView& message) {
    const auto command = decode<PilotRevertData>(message);
    if (!command) return command.error();
    const std::lock_guard lock(state_mutex_);
    if (!driver_.has_begun() || !is_on()) return refused("the pilot is off; turn it on first");
    record(PilotRecord::kRevert, *command);
    driver_.revert(*command);
    return {};
  }

  OwnMailbox work_{*this, 10, body_max<PathData>()};
  OwnMailbox command_work_{*this, 4, 256};  // used by the worker, with command_path_
  OwnMailbox request_work_{*this, 4, 256};
  Partner<PathProxy> command_path_{*this, "path", command_work_, kPlanningTimeouts};
  Partner<PathProxy> request_path_{*this, "path", request_work_, kPlanningTimeouts};
  Feed<Scan2dProxy> scan_{{*this, "scan2d", work_, 2, body_max<Scan2dData>()}};
  Feed<PositionProxy> position_{{*this, "position", work_, 10, wire_size<PositionData>()}};
  Input<ChassisProxy> chassis_{*this, "chassis", work_, 10, wire_size<ChassisData>()};
  Feed<PathProxy> path_{{*this, "path", work_, 2, body_max<PathData>()}};

  PriorityMutex state_mutex_;  // protects the members below; inputs() is used by the data task only
  PathDriver driver_;
  bool asks_next_ = false;  // a path to the next destination of a list was requested
  std::unique_ptr<device::CaptureFile> capture_;  // nullptr: no recording
  std::vector<std::byte> bytes_;                  // buffer for a record
  u32 records_ = 0;
  std::optional<TimeStamp> recorded_path_;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotPath pilot;
  return pilot.run(argc, argv);
}
