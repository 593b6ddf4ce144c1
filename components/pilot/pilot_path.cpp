// PilotPath: follows a path, and stops before obstacles. While position, path or scans are away it
// stands and asks for them again; where it was sent to stays.
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

constexpr int kSilence = 10;  // periods without a message of an input
constexpr int kSilenceMost = 1000000;
constexpr milliseconds kAskAgain{1000};
constexpr milliseconds kAskFor{50};  // it stands then

constexpr std::array<ParameterInfo, 15> kParameters = {{
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
    {"record", "", "file that what it receives and decides is recorded in, for pilot-replay"},
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
    bytes_.resize(std::max(body_max<PathData>(), body_max<Scan2dData>()));
  }

 private:
  Result<void> module_init() override {
    if (auto made = create_mailbox(work_, 10, body_max<PathData>()); !made) return made;
    if (auto made = create_mailbox(command_work_, 4, 256); !made) return made;
    if (auto made = create_mailbox(errand_work_, 4, 256); !made) return made;
    if (auto made = create_input(scan_.input, *work_, 2, body_max<Scan2dData>()); !made)
      return made;
    if (auto made = create_input(position_.input, *work_, 10, wire_size<PositionData>()); !made)
      return made;
    if (auto made = create_input(chassis_, *work_, 10, wire_size<ChassisData>()); !made)
      return made;
    return create_input(path_.input, *work_, 2, body_max<PathData>());
  }

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
    errand_.emplace(*errand_work_, address_of(tims::class_id::kPath, "path"), kPlanningTimeouts);
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

  // One that it can be without for a while.
  template <typename ProxyType>
  struct Feed {
    std::optional<Input<ProxyType>> input{};
    int patience = kSilence;            // looks
    int left = 0;                       // of it
    int silence = 0;                    // looks since something came
    std::optional<tims::Time> asked{};  // while it is away
  };

  Result<void> start_inputs(PathDriverSettings& settings) {
    looks_ = integer("scan2dInst") >= 0;
    settings.looks = looks_ ? 1 : 0;
    const auto chassis = chassis_->start(address_of(tims::class_id::kChassis, "chassis"));
    if (!chassis) return chassis.error();
    const auto limits = chassis_->proxy().get_parameter();
    if (!limits) return limits.error();
    settings.chassis = *limits;
    settings.chassisPeriod = milliseconds_of(*chassis);
    const auto position = begin_feed(position_, tims::class_id::kPosition, "position");
    if (!position) return position.error();
    settings.positionPeriod = milliseconds_of(*position);
    const auto path = begin_feed(path_, tims::class_id::kPath, "path");
    if (!path) return path.error();
    settings.pathPeriod = milliseconds_of(*path);
    if (!looks_) return {};
    const auto scan = begin_feed(scan_, tims::class_id::kScan2d, "scan2d");
    if (!scan) return scan.error();
    settings.scanPeriod = milliseconds_of(*scan);
    return {};
  }
  template <typename ProxyType>
  Result<milliseconds> begin_feed(Feed<ProxyType>& feed, std::uint32_t class_id,
                                  std::string_view name) {
    feed.silence = 0;
    feed.left = kSilence;
    feed.asked.reset();
    return feed.input->start(address_of(class_id, name));
  }
  static i32 milliseconds_of(milliseconds time) { return static_cast<i32>(time.count()); }

  void module_off() override {
    if (chassis_->started()) (void)chassis_->proxy().move(0, 0, 0);
    chassis_->stop();
    position_.input->stop();
    path_.input->stop();
    scan_.input->stop();
    finish_recording();
  }

  // --- again and again

  Result<void> module_loop() override {
    sleep_until_next(period());
    PathLook look{.deviationMax = integer("deviationMax"), .replanTime = integer("replanTime")};
    if (auto good = look_at_all(look); !good) return good;
    ChassisMoveData move;
    PathDriver::Errand errand;
    {
      const std::lock_guard lock(state_mutex_);
      move = decide(look);
      driver_.describe(get_local_buffer());
      errand = driver_.take_errand();
    }
    auto moved = chassis_->proxy().move(move.vx, move.vy, move.omega);
    if (!moved) return moved;
    tell_refusal(errand_->take_answer());
    if (auto sent = go_on(errand); !sent) tell_refusal(sent);
    return put_local_buffer();
  }

  // Under state_mutex_: a command comes before it or after it, and is recorded so.
  ChassisMoveData decide(PathLook& look) {
    const bool was_unsure = driver_.is_unsure();
    look.time = time_stamp();
    record_inputs(look);
    const ChassisMoveData move = driver_.look(look);
    record(PilotRecord::kMove, move);
    record(PilotRecord::kStatus, driver_.status());
    tell_recording();
    if (driver_.is_unsure() != was_unsure) {
      if (was_unsure)
        log().print("It is known again where it is");
      else
        log().warning("It stops: nobody is sure where it is");
    }
    return move;
  }

  Result<void> look_at_all(PathLook& look) {
    PathDriver::Inputs& inputs = driver_.inputs();
    const auto come = chassis_->newest(inputs.chassis, kSilence);
    if (!come) return come.error();
    if (*come) look.came |= PathLook::kChassis;
    look.chassisSilence = chassis_->silence();
    if (take(position_, inputs.position)) look.came |= PathLook::kPosition;
    if (take(path_, inputs.path)) look.came |= PathLook::kPath;
    look.positionSilence = position_.silence;
    look.pathSilence = path_.silence;
    if (!looks_) return {};
    if (take(scan_, inputs.scan)) look.came |= PathLook::kScan;
    look.scanSilence = scan_.silence;
    return {};
  }

  template <typename ProxyType>
  bool take(Feed<ProxyType>& feed, typename ProxyType::Data& data) {
    const auto come = feed.asked ? Result<bool>(false) : feed.input->newest(data);
    if (come && *come) {
      feed.silence = 0;
      feed.left = feed.patience;
      return true;
    }
    feed.silence = std::min(feed.silence + 1, kSilenceMost);
    if (feed.asked) {
      ask_again(feed);
    } else if (!come || --feed.left <= 0) {
      log().warning("%s: it stands until that is back",
                    come ? "no data of " + name_of(feed) : std::string(come.error().message()));
      feed.asked = now();
    }
    return false;
  }

  template <typename ProxyType>
  void ask_again(Feed<ProxyType>& feed) {
    if (now() - *feed.asked < kAskAgain) return;
    feed.asked = now();
    const tims::Address producer = feed.input->proxy().component();
    const ProxyTimeouts timeouts{.on = kAskFor, .off = kAskFor, .data = kAskFor};
    if (!feed.input->start(producer, {}, timeouts)) return;
    feed.asked.reset();
    feed.left = feed.patience;
    log().print("%s is back", name_of(feed));
  }

  template <typename ProxyType>
  std::string name_of(Feed<ProxyType>& feed) {
    return feed.input->proxy().component().to_string(address_widths());
  }

  // --- what others do for it

  // Planning takes its time: the answer is taken at a later look.
  Result<void> go_on(const PathDriver::Errand& errand) {
    if (!errand.around && !errand.next) return {};
    {
      const std::lock_guard lock(state_mutex_);
      asks_next_ = errand.next.has_value();
    }
    if (errand.around) return errand_->post_replan(*errand.around);
    return errand_->post_destination(destination_of(errand.next->pos, errand.next->speed));
  }
  void tell_refusal(const std::optional<Result<void>>& done) {
    if (!done) return;
    const std::lock_guard lock(state_mutex_);
    const bool is_of_next = std::exchange(asks_next_, false);
    if (*done) return;
    log().warning("%s", done->error().message());
    if (is_of_next) plan(pilot_state::kPathError);
  }

  static PathDestData destination_of(const Position3d& pos, i32 speed) {
    return {.pos = {pos.x, pos.y, pos.rho}, .speed = speed};
  }

  // --- the recording; under state_mutex_

  template <typename T>
  void record(PilotRecord kind, const T& message) {
    if (!capture_) return;
    const auto size = encode(message, std::span(bytes_));
    if (!size) return;
    const bool is_said = kind == PilotRecord::kMove || kind == PilotRecord::kStatus;
    capture_->add(now(), is_said ? device::Direction::kSent : device::Direction::kReceived,
                  static_cast<std::uint32_t>(kind), std::span(bytes_).first(*size));
    ++records_;
  }

  // Of the path only what is another one: it is long, and comes again and again.
  void record_inputs(const PathLook& look) {
    if (!capture_) return;
    const PathDriver::Inputs& inputs = driver_.inputs();
    if ((look.came & PathLook::kPosition) != 0) record(PilotRecord::kPosition, inputs.position);
    if ((look.came & PathLook::kChassis) != 0) record(PilotRecord::kChassis, inputs.chassis);
    if ((look.came & PathLook::kPath) != 0 && inputs.path.recordingTime != recorded_path_) {
      recorded_path_ = inputs.path.recordingTime;
      record(PilotRecord::kPath, inputs.path);
    }
    if ((look.came & PathLook::kScan) != 0) record(PilotRecord::kScan, inputs.scan);
    record(PilotRecord::kLook, RecordedLook{look, records_});
  }

  void tell_recording() {
    if (!capture_) return;
    if (const auto event = capture_->take_event()) log().warning("%s", *event);
  }

  void finish_recording() {
    const std::lock_guard lock(state_mutex_);
    if (capture_) capture_->finish();
    tell_recording();
    capture_.reset();
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
        reply(message.header, PilotType::kStatus, driver_.status());
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
    PathProxy path(*command_work_, address_of(tims::class_id::kPath, "path"), kPlanningTimeouts);
    auto good = path.set_destination(destination_of(pos, speed));
    if (!good) begin_planning(before);
    return good;
  }

  u32 begin_planning(u32 state) {
    const std::lock_guard lock(state_mutex_);
    asks_next_ = false;
    return plan(state);
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
    const auto wish = decode<PilotDestData>(message);
    if (!wish) return wish.error();
    keep({});
    return go_to(wish->pos, wish->speed);
  }

  Result<void> set_destinations(const tims::MessageView& message) {
    auto wish = decode<PilotMultiDestData>(message);
    if (!wish) return wish.error();
    if (wish->points.empty()) return refused("no destination is among them");
    const DestinationPoint first = wish->points.front();
    if (auto good = go_to(first.pos, first.speed); !good) return good;
    wish->points.erase(wish->points.begin());
    keep(*wish);
    return {};
  }

  Result<void> hold(const tims::MessageView& message) {
    const auto wish = decode<PilotHoldData>(message);
    if (!wish) return wish.error();
    const std::lock_guard lock(state_mutex_);
    if (!driver_.has_begun()) return refused("turn it on first");
    record(PilotRecord::kHold, *wish);
    driver_.hold(*wish);
    return {};
  }

  Result<void> revert(const tims::MessageView& message) {
    const auto wish = decode<PilotRevertData>(message);
    if (!wish) return wish.error();
    const std::lock_guard lock(state_mutex_);
    if (!driver_.has_begun() || !is_on()) return refused("turn it on first");
    record(PilotRecord::kRevert, *wish);
    driver_.revert(*wish);
    return {};
  }

  tims::Mailbox* work_ = nullptr;
  tims::Mailbox* command_work_ = nullptr;  // of the command task
  tims::Mailbox* errand_work_ = nullptr;
  std::optional<PathProxy> errand_;
  Feed<Scan2dProxy> scan_;
  Feed<PositionProxy> position_;
  Feed<PathProxy> path_;
  std::optional<Input<ChassisProxy>> chassis_;
  bool looks_ = false;

  PriorityMutex state_mutex_;  // of what follows; inputs() is of the data task alone
  PathDriver driver_;
  bool asks_next_ = false;  // the path, for the way to the next destination of a list
  std::unique_ptr<device::CaptureFile> capture_;  // or none
  std::vector<std::byte> bytes_;                  // of a record
  u32 records_ = 0;
  std::optional<TimeStamp> recorded_path_;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotPath pilot;
  return pilot.run(argc, argv);
}
