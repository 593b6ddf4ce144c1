#include "tools/evaluation/dora/scenario.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "os/clock.h"
#include "rack/clock.h"
#include "rack/proxies/chassis.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/dora/cross_track.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;
using timsctl::Exit;
using timsctl::Failure;

constexpr Duration kStep = 20ms;
constexpr Duration kScenarioPatience = 30s;
constexpr Duration kSettles = 2s;  // from a disturbance to normal driving
constexpr Duration kPeriodsMin = 10s;
constexpr Duration kSlowPeriods = 1s;        // a short run has too few of these
constexpr Duration kShort = 45s;             // a shorter --for leaves out the long steps
constexpr Duration kStopsMax = 2s;           // waiting time
constexpr double kStopMs = 200;              // (f)
constexpr double kReturnMs = 5000;           // (f)
constexpr double kReactsMs = 13.3 + 50 + 5;  // (b), p99
constexpr double kReactsMaxMs = 80;
constexpr double kLateralMm = 150;   // (d)
constexpr double kPositionMm = 150;  // (e)
constexpr double kSatelliteMm = 2000;
constexpr double kBlindMs = 3 * 13.3 + 50;  // (g)
constexpr double kSeesMs = 2000;
constexpr Duration kSearchesMin = 2min;  // least --for for the steps of (e) that take long
constexpr i32 kDrives = 300;             // mm/s

// The serial lines of the world have fixed names in /tmp, so only one run is possible at a time.
tims::os::File alone() {
  const std::string path = std::filesystem::temp_directory_path() / "rack-dora.lock";
  tims::os::File lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!lock) throw Failure(Exit::kDenied, "no_lock", "cannot open " + path);
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw Failure(Exit::kDenied, "runs_already", "another rack-dora runs on this machine",
                  "wait until it has ended");
  return lock;
}

}  // namespace

Scenario::Scenario(const Settings& settings, const timsctl::Signals& signals)
    : alone_(alone()),
      settings_(settings),
      signals_(signals),
      began_(tims::os::now()),
      name_(fmt::format("dora{}", ::getpid() % 100000)),
      log_(std::filesystem::temp_directory_path() / (name_ + ".log")) {}

Scenario::~Scenario() {
  load_.reset();
  subscriptions_.clear();
  save_logs();
  fleet_.reset();
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
  for (const std::string_view component : kRecorded)
    std::filesystem::remove(recording_of(component), ignored);
}

// The logs are also saved if the run was interrupted or failed.
void Scenario::save_logs() const {
  if (settings_.logs.empty() || !fleet_) return;
  try {
    fleet_->save(settings_.logs);
    std::ofstream(std::filesystem::path(settings_.logs) / "drive.csv") << drive_csv();
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr, "rack-dora: {}\n", error.what());
  }
}

Outcome Scenario::run() {
  ReferenceTimer timer;
  ReferenceTerminal terminal;
  bring_up();
  begin_to_drive();
  driving_since_ = tims::os::now();
  measure_periods(is_short() ? kPeriodsMin / 2 : std::max(kPeriodsMin, settings_.length / 10));
  note_cross_track_errors(driving_since_ + kSettles);
  try_obstacles(tims::os::now() + settings_.length * 2 / 5, reactions_ms_);
  notes_.end_span();
  if (!is_short()) try_obstacles_under_load(std::max(kPeriodsMin, settings_.length / 5));
  pull_out_her_eyes();
  if (settings_.length >= kSearchesMin) {
    carry_her_away();
    drive_by_satellites(settings_.length / 8);
  }
  kill_routers();
  replay_all();
  Outcome outcome{.rows = {}, .reference = {.timer = timer.end(), .terminal = terminal.end()}};
  judge_periods(outcome.reference);
  judge_trials(outcome.reference.timer);
  std::ranges::stable_sort(rows_, {}, &Row::check);
  outcome.rows = std::move(rows_);
  return outcome;
}

void Scenario::judge_trials(const TimerQuality& timer) {
  const auto latency = [&](const LatencyLimits& limits, const std::vector<double>& ms) {
    rows_.push_back(judge_latency(limits, ms, timer));
  };
  judge_reactions(timer);
  const double minutes = std::chrono::duration<double>(obstacles_for_) / 1min;
  rows_.push_back(judge_fact(
      "c", "posts that appear just beyond the stopping distance", "0 contacts",
      fmt::format("{} contacts with {} posts, {:.0f} a minute", contacts_, posts_,
                  posts_ / minutes),
      contacts_ == 0 && posts_ > 0, "breakConstant and lag of Pilot(1/0); the scan at that time"));
  const std::string contacts = other_contacts();
  rows_.push_back(judge_fact("c", "walls, parked cars and people on the round", "0 contacts",
                             contacts.empty() ? "0 contacts" : contacts, contacts.empty(),
                             "people who step in front of the robot (avoids); the position error"));
  rows_.push_back(judge_amount({.check = "d",
                                .what = "cross-track error at 3 m/s and more",
                                .look = "the position error; lag and steeringRate of Pilot(1/0)",
                                .unit = "mm",
                                .most = kLateralMm,
                                .digits = 0},
                               lateral_mm_));
  rows_.push_back(judge_amount({.check = "e",
                                .what = "position error with the laser",
                                .look = "the log of Mcl(1/0); timsctl component data Mcl/1/0",
                                .unit = "mm",
                                .most = kPositionMm,
                                .digits = 0},
                               position_mm_));
  if (settings_.length >= kSearchesMin) {
    rows_.push_back(judge_amount({.check = "e",
                                  .what = "position error by satellites only",
                                  .look = "timsctl component data Gps/1/0; positionUpdate",
                                  .unit = "mm",
                                  .most = kSatelliteMm,
                                  .digits = 0},
                                 satellite_errors_));
  } else {
    rows_.push_back(left_out("e", "carried away; satellites only", "needs --for 2min"));
  }
  const std::string missed = "the log of Pilot(1/0): which input was missing, and when";
  const std::string returned = "timsctl component list: components that have not returned";
  latency({.check = "f",
           .what = "the router of a host is killed: time to MOVE 0",
           .look = missed,
           .max_ms = kStopMs},
          stops_ms_);
  latency({.check = "f",
           .what = "the router is back: time until the robot drives",
           .look = returned,
           .max_ms = kReturnMs},
          returns_ms_);
  const std::vector<std::string> ended = fleet_->ended();
  rows_.push_back(judge_fact("f", "programs that ended unexpectedly", "0",
                             std::to_string(ended.size()), ended.empty(),
                             ended.empty() ? "" : ended.front()));
  latency({.check = "g",
           .what = "the laser is unplugged: time to MOVE 0",
           .look = missed,
           .max_ms = kBlindMs},
          unplugged_ms_);
  latency({.check = "g",
           .what = "the laser is plugged in: time until the robot drives",
           .look = returned,
           .max_ms = kSeesMs},
          plugged_ms_);
}

void Scenario::judge_reactions(const TimerQuality& timer) {
  LatencyLimits limits{
      .check = "b",
      .what = "from a post in the scan to MOVE 0",
      .look = "timsctl msg hz Scan2d(1/0) Pilot(1/0) at robot1-drive; robot1-laser's line",
      .p99_ms = kReactsMs,
      .max_ms = kReactsMaxMs};
  rows_.push_back(judge_latency(limits, reactions_ms_, timer));
  limits.what = "the same under load (camera pictures and a recording to the base)";
  if (!load_) {
    rows_.push_back(left_out(limits.check, limits.what, is_short() ? "needs --for 45s" : no_load_));
    return;
  }
  rows_.push_back(judge_latency(limits, loaded_reactions_ms_, timer));
  const double seconds = std::chrono::duration<double>(load_->length()).count();
  rows_.push_back(judge_fact(
      limits.check, "load to the base", "pictures of 1 MiB, data sets",
      fmt::format("{} of {:.2f} MiB ({:.0f} % of those taken), {} data sets in {:.0f} s",
                  load_->pictures(), static_cast<double>(load_->picture_bytes()) / (1U << 20),
                  100 * load_->share(), load_->recorded(), seconds),
      load_->share() > 0.7 && load_->recorded() > 0 && load_->picture_bytes() >= 1U << 20,
      "the logs of Camera(1/0) and Datalog(1/0); timsctl link show at the base"));
}

// Rows about the limits of the measurement for (a).
void Scenario::judge_means(const TimerQuality& timer) {
  if (timer.source != "cyclictest")
    rows_.push_back(left_out("a", "cyclictest",
                             "not installed (package rt-tests); an equivalent loop ran instead"));
  if (!timer.real_time || !std::ranges::all_of(subscriptions_, &Subscriptions::is_real_time))
    rows_.push_back(left_out("a", "real-time priorities",
                             "not permitted (CAP_SYS_NICE): all measured times are late"));
}

// --- starting the fleet and the drive

void Scenario::bring_up() {
  print_progress("starting the fleet " + settings_.fleet_file);
  fleet_.emplace(timsctl::sim::RunningFleet::Options{
      .name = name_, .file = settings_.fleet_file, .log = log_});
  std::vector<std::string_view> hosts(kHosts.begin(), kHosts.end());
  hosts.push_back(kBase);
  for (const std::string_view host : hosts)
    subscriptions_.push_back(
        std::make_unique<Subscriptions>(host, fleet_->socket(std::string(host)),
                                        [this](std::size_t stream, const tims::MessageView& message,
                                               Time at) { notes_.take(stream, message, at); }));
  if (!std::ranges::all_of(subscriptions_, &Subscriptions::is_real_time))
    print_progress("real-time priorities are not permitted: all measured times are late");
}

// Retries: the other routers may not know the component yet.
void Scenario::ask(std::string_view component,
                   const std::function<Result<void>(Proxy&)>& question) {
  Proxy proxy(work(), address_of(component), {.on = 5s});
  std::string why;
  const bool done = await(kScenarioPatience, [&] {
    const auto answer = question(proxy);
    if (!answer) why = answer.error().message();
    return answer.ok();
  });
  if (!done)
    throw Failure(Exit::kNo, "refused", why, "see the log of the component: timsctl log follow");
}

void Scenario::turn_on(std::string_view component) { ask(component, &Proxy::on); }

// Recording starts at the next ON of each component. Which file is written can be set only by a
// program of the component's own host.
void Scenario::record_all() {
  for (const std::string_view component : kRecorded) {
    Parameter record{.type = Parameter::kString};
    (void)record.name.assign("record");
    (void)record.valueString.assign(recording_of(component));
    std::string why;
    const bool done = await(kScenarioPatience, [&] {
      return std::ranges::any_of(subscriptions_, [&](const auto& host) {
        const auto set = Proxy(host->work(), address_of(component), {.on = 5s}).set_param(record);
        if (!set) why = set.error().message();
        return set.ok();
      });
    });
    if (!done) throw Failure(Exit::kNo, "refused", why, "see the log of the component");
  }
}

std::string Scenario::recording_of(std::string_view component) const {
  const std::string_view name = component.substr(0, component.find('('));
  return std::filesystem::temp_directory_path() / fmt::format("{}-{}.cap", name_, name);
}

void Scenario::begin_to_drive() {
  record_all();
  for (const std::string_view component : {"Chassis(1/0)", "Gyro(1/0)", "Gps(1/0)", "Path(1/0)"})
    turn_on(component);
  if (!await(kScenarioPatience, [&] { return !notes_.path().splines.empty(); }))
    throw Failure(Exit::kNo, "no_path", "Path(1/0) does not send a path", "see its log");
  if (!await(kScenarioPatience, [&] { return notes_.truth().at != Time{}; }))
    throw Failure(Exit::kNo, "no_world", "World(1/0) does not report the true state",
                  "see its log at the base");
  begin_round();
  turn_on("Mcl(1/0)");
  ChassisProxy chassis(work(), address_of("Chassis(1/0)"));
  timsctl::value_or_fail(chassis.set_active_pilot(address_of("Pilot(1/0)")), "Chassis(1/0)");
  turn_on("Pilot(1/0)");
  if (!drives_within(kScenarioPatience))
    throw Failure(Exit::kNo, "no_drive", "the robot does not start driving",
                  "timsctl component data Pilot/1/0");
  print_progress("the robot drives");
}

// Places the robot in the world and initialises Position with the same pose.
void Scenario::begin_round() {
  const Position2d start = notes_.path().splines.front().startPos;
  timsctl::value_or_fail(WorldProxy(base(), world()).place("dora", start), "World(1/0)");
  pause(200ms);
  PositionProxy position(work(), address_of("Position(1/0)"));
  PositionData known = timsctl::value_or_fail(position.get_data(), "Position(1/0)");
  known.pos = {.x = start.x, .y = start.y, .rho = start.rho};
  known.var = {.x = 100, .y = 100, .rho = 0.03F};
  timsctl::value_or_fail(position.update(known), "Position(1/0)");
}

bool Scenario::is_short() const { return settings_.length < kShort; }

bool Scenario::is_near_end(double rest) const {
  const PathData path = notes_.path();
  const auto place = project_onto(path.splines, notes_.truth().pose);
  return !place || remaining_length(path.splines, *place) < rest;
}

void Scenario::keep_driving(double rest) {
  if (!is_near_end(rest) && drives_within(3s)) return;
  print_progress("    starting another round");
  const bool counts = notes_.counts();
  notes_.end_span();
  Proxy mcl(work(), address_of("Mcl(1/0)"));
  Proxy path(work(), address_of("Path(1/0)"));
  (void)mcl.off();
  (void)path.off();
  begin_round();
  turn_on("Path(1/0)");
  turn_on("Mcl(1/0)");
  turn_on("Pilot(1/0)");
  if (!drives_within(kScenarioPatience))
    throw Failure(Exit::kNo, "no_drive",
                  "the robot does not drive another round: " + where_she_is(),
                  "keep the logs of all programs with --logs FOLDER");
  if (!counts) return;
  pause(kSettles);
  notes_.begin_span();
}

std::string Scenario::where_she_is() const {
  const Pose truth = notes_.truth().pose;
  const Position3d known = notes_.position().pos;
  const auto pilot = notes_.newest_pilot();
  return fmt::format("true position {:.0f} {:.0f} mm, estimated {} {} mm, pilot state {}", truth.x,
                     truth.y, known.x.raw(), known.y.raw(), pilot ? pilot->state : 0);
}

// True and estimated poses; timsctl nav plot draws them.
std::string Scenario::drive_csv() const {
  std::string text =
      "time_s,truth_x_m,truth_y_m,position_x_m,position_y_m,position_error_m,path_error_m,"
      "speed_mps\n";
  const PathData path = notes_.path();
  for (const PositionNote& note : notes_.positions(driving_since_)) {
    const Pose& truth = note.truth.pose;
    const auto place = project_onto(path.splines, truth);
    text += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f}\n",
                        std::chrono::duration<double>(note.at - began_).count(), truth.x / 1000,
                        truth.y / 1000, note.pose.x / 1000, note.pose.y / 1000, note.error() / 1000,
                        place ? place->across / 1000 : 0, note.truth.speed / 1000);
  }
  return text;
}

// Time, place and speed of each contact.
std::string Scenario::other_contacts() const {
  std::string text;
  const std::vector<TruthNote> truths = notes_.truths(driving_since_);
  for (std::size_t i = 1; i < truths.size(); ++i) {
    const TruthNote& before = truths[i - 1];
    const TruthNote& now = truths[i];
    if (now.walls == before.walls && now.people == before.people) continue;
    text += fmt::format("{}{} at {:.1f} s, {:.0f} {:.0f} mm, {:.0f} mm/s", text.empty() ? "" : "; ",
                        now.walls != before.walls ? "a wall" : "a person",
                        std::chrono::duration<double>(now.at - began_).count(), now.pose.x,
                        now.pose.y, before.speed);
  }
  return text;
}

tims::Address Scenario::world() { return address_of("World(1/0)"); }

Parameter Scenario::integer_parameter(std::string_view name, i32 value) {
  Parameter parameter{.type = Parameter::kInt, .valueInt = value};
  (void)parameter.name.assign(name);
  return parameter;
}

TimeStamp Scenario::wall_of(Time time) {
  const auto ago = std::chrono::duration_cast<std::chrono::milliseconds>(tims::os::now() - time);
  return time_stamp() - ago;
}

std::optional<Duration> Scenario::drives_within(Duration limit, std::optional<Time> since_when) {
  const Time since = since_when.value_or(tims::os::now());
  std::optional<PilotNote> note;
  await(limit, [&] {
    note = notes_.pilot(since, [](const PilotNote& pilot) { return pilot.speed >= kDrives; });
    return note.has_value();
  });
  if (!note) return {};
  return note->at - since;
}

// --- (a)

void Scenario::measure_periods(Duration length) {
  pause(kSettles);
  print_progress(
      fmt::format("(a) periods, for {:.0f} s", std::chrono::duration<double>(length).count()));
  notes_.begin_span();
  pause(length);  // the span continues during the obstacle trials
}

void Scenario::judge_periods(const Reference& reference) {
  judge_means(reference.timer);
  for (std::size_t i = 0; i < kComponents; ++i) {
    const Stream& stream = kStreams.at(i);
    if (is_short() && stream.period_ms >= milliseconds(kSlowPeriods))
      rows_.push_back(left_out("a", "period of " + std::string(stream.component),
                               "too few periods: needs --for 45s"));
    else
      rows_.push_back(judge_period({.name = std::string(stream.component),
                                    .period_ms = stream.period_ms,
                                    .from_a_line = stream.from_a_line},
                                   notes_.spans(i), reference));
  }
}

// --- (f)

void Scenario::kill_routers() {
  for (const std::string_view host : kHosts) {
    if (!is_short() || host == kHosts.front())
      kill_router(host);
    else
      rows_.push_back(
          left_out("f", fmt::format("the router of {} is killed", host), "needs --for 45s"));
  }
}

void Scenario::kill_router(std::string_view host) {
  keep_driving();
  pause(kSettles);
  print_progress(fmt::format("(f) the router of {} is killed", host));
  const Time killed = fleet_->kill_router(std::string(host));
  std::optional<PilotNote> stop;
  await(kStopsMax, [&] {
    stop = notes_.pilot(killed, [](const PilotNote& pilot) { return pilot.speed == 0; });
    return stop.has_value();
  });
  if (stop) stops_ms_.push_back(milliseconds(stop->at - killed));
  print_progress(stop ? fmt::format("    MOVE 0 after {:.0f} ms", stops_ms_.back())
                      : std::string("    the robot does not stop"));
  if (!stop) stops_ms_.push_back(milliseconds(kStopsMax));
  const Time returned = tims::os::now();
  fleet_->sim({"start", std::string(host)});
  const auto back = drives_within(2 * kScenarioPatience / 3, returned);
  returns_ms_.push_back(milliseconds(back.value_or(2 * kScenarioPatience / 3)));
  print_progress(back ? fmt::format("    the robot drives {:.1f} s after the router is back",
                                    returns_ms_.back() / 1000)
                      : std::string("    the robot does not drive again"));
}

// --- helpers

bool Scenario::await(Duration limit, const std::function<bool()>& so) {
  const Time end = tims::os::now() + limit;
  for (;;) {
    if (so()) return true;
    if (tims::os::now() >= end) return false;
    for (const auto& subscriptions : subscriptions_) subscriptions->renew();
    if (load_) load_->keep();
    signals_.sleep_until(std::min(end, tims::os::now() + kStep));
  }
}

void Scenario::pause(Duration length) {
  (void)await(length, [] { return false; });
}

Duration Scenario::elapsed() const { return tims::os::now() - began_; }

void Scenario::print_progress(const std::string& text) const {
  if (settings_.quiet) return;
  fmt::print("{:7.2f}  {}\n", std::chrono::duration<double>(elapsed()).count(), text);
  std::fflush(stdout);
}

}  // namespace rack::dora
