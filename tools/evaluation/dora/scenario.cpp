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
#include "tools/evaluation/dora/track.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;
using timsctl::Exit;
using timsctl::Failure;

constexpr Duration kStep = 20ms;
constexpr Duration kScenarioPatience = 30s;
constexpr Duration kSettles = 2s;  // after something was done to her, until she is as before
constexpr Duration kPeriodsMin = 10s;
constexpr Duration kSlowPeriods = 1s;        // in a short run there are too few of these
constexpr Duration kShort = 45s;             // of --for: below, what takes long is left out
constexpr Duration kStopsMax = 2s;           // waited for
constexpr double kStopMs = 200;              // (f)
constexpr double kReturnMs = 5000;           // (f)
constexpr double kReactsMs = 13.3 + 50 + 5;  // (b), p99
constexpr double kReactsMaxMs = 80;
constexpr double kLateralMm = 150;   // (d)
constexpr double kPositionMm = 150;  // (e)
constexpr double kSatelliteMm = 2000;
constexpr double kBlindMs = 3 * 13.3 + 50;  // (g)
constexpr double kSeesMs = 2000;
constexpr Duration kSearchesMin = 2min;  // of --for, for what takes long
constexpr i32 kDrives = 300;             // mm/s

// The serial lines of her world have names of their own in /tmp: there is one of her on a machine.
tims::os::File alone() {
  const std::string path = std::filesystem::temp_directory_path() / "rack-dora.lock";
  tims::os::File lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!lock) throw Failure(Exit::kDenied, "no_lock", path + ": cannot be opened");
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw Failure(Exit::kDenied, "runs_already", "she drives here already", "wait until that ends");
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
  ears_.clear();
  save_logs();
  fleet_.reset();
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
  for (const std::string_view component : kRecorded)
    std::filesystem::remove(recording_of(component), ignored);
}

// Also of a run that somebody or something ended.
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
  note_track(driving_since_ + kSettles);
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
  const auto latency = [&](const LatencyWish& wish, const std::vector<double>& ms) {
    rows_.push_back(judge_latency(wish, ms, timer));
  };
  judge_reactions(timer);
  const double minutes = std::chrono::duration<double>(obstacles_for_) / 1min;
  rows_.push_back(judge_fact("c", "posts that appear where she can just stop", "0 contacts",
                             fmt::format("{} contacts with {} posts, {:.0f} a minute", contacts_,
                                         posts_, posts_ / minutes),
                             contacts_ == 0 && posts_ > 0, "breakConstant and lag; the scan then"));
  const std::string contacts = other_contacts();
  rows_.push_back(judge_fact("c", "walls, parked cars and people on her round", "0 contacts",
                             contacts.empty() ? "0 contacts" : contacts, contacts.empty(),
                             "people who step before her (avoids); the position's error"));
  rows_.push_back(judge_amount({.check = "d",
                                .what = "beside her path at 3 m/s and more",
                                .look = "the position's error; lag and steeringRate of Pilot(1/0)",
                                .unit = "mm",
                                .most = kLateralMm,
                                .digits = 0},
                               lateral_mm_));
  rows_.push_back(judge_amount({.check = "e",
                                .what = "position's error with her laser",
                                .look = "the log of Mcl(1/0); timsctl component data Mcl/1/0",
                                .unit = "mm",
                                .most = kPositionMm,
                                .digits = 0},
                               position_mm_));
  if (settings_.length >= kSearchesMin) {
    rows_.push_back(judge_amount({.check = "e",
                                  .what = "position's error by satellites alone",
                                  .look = "timsctl component data Gps/1/0; positionUpdate",
                                  .unit = "mm",
                                  .most = kSatelliteMm,
                                  .digits = 0},
                                 satellite_errors_));
  } else {
    rows_.push_back(left_out("e", "carried away; satellites alone", "needs --for 2min"));
  }
  const std::string missed = "the log of Pilot(1/0): what it missed, and when";
  const std::string returned = "timsctl component list, and who has not come back";
  latency({.check = "f",
           .what = "a host's router is killed: told to stand",
           .look = missed,
           .max_ms = kStopMs},
          stops_ms_);
  latency({.check = "f",
           .what = "the router is back: she goes on by herself",
           .look = returned,
           .max_ms = kReturnMs},
          returns_ms_);
  const std::vector<std::string> ended = fleet_->ended();
  rows_.push_back(judge_fact("f", "no program ends by itself", "0", std::to_string(ended.size()),
                             ended.empty(), ended.empty() ? "" : ended.front()));
  latency({.check = "g",
           .what = "her laser is pulled out: told to stand",
           .look = missed,
           .max_ms = kBlindMs},
          unplugged_ms_);
  latency({.check = "g",
           .what = "it is plugged in: she goes on by herself",
           .look = returned,
           .max_ms = kSeesMs},
          plugged_ms_);
}

void Scenario::judge_reactions(const TimerQuality& timer) {
  LatencyWish wish{
      .check = "b",
      .what = "a post in the scan until MOVE 0",
      .look = "timsctl msg hz Scan2d(1/0) Pilot(1/0) at robot1-drive; robot1-laser's line",
      .p99_ms = kReactsMs,
      .max_ms = kReactsMaxMs};
  rows_.push_back(judge_latency(wish, reactions_ms_, timer));
  wish.what = "the same while a camera and a recording go to the base";
  if (!load_) {
    rows_.push_back(left_out(wish.check, wish.what, is_short() ? "needs --for 45s" : no_load_));
    return;
  }
  rows_.push_back(judge_latency(wish, loaded_reactions_ms_, timer));
  const double seconds = std::chrono::duration<double>(load_->length()).count();
  rows_.push_back(judge_fact(
      wish.check, "what goes to the base meanwhile", "pictures of 1 MiB, data sets",
      fmt::format("{} of {:.2f} MiB ({:.0f} % of the camera's), {} data sets in {:.0f} s",
                  load_->pictures(), static_cast<double>(load_->picture_bytes()) / (1U << 20),
                  100 * load_->share(), load_->recorded(), seconds),
      load_->share() > 0.7 && load_->recorded() > 0 && load_->picture_bytes() >= 1U << 20,
      "the logs of Camera(1/0) and Datalog(1/0); timsctl link show at the base"));
}

// What (a) is judged beside.
void Scenario::judge_means(const TimerQuality& timer) {
  if (timer.source != "cyclictest")
    rows_.push_back(left_out("a", "cyclictest beside it",
                             "it is not installed (rt-tests); a loop of its kind ran instead"));
  if (!timer.real_time || !std::ranges::all_of(ears_, &Ears::is_real_time))
    rows_.push_back(left_out("a", "real-time priorities",
                             "no right to them (CAP_SYS_NICE): all periods are as late as others"));
}

// --- the fleet, and that she drives

void Scenario::bring_up() {
  say("the fleet: " + settings_.fleet_file);
  fleet_.emplace(timsctl::sim::RunningFleet::Options{
      .name = name_, .file = settings_.fleet_file, .log = log_});
  std::vector<std::string_view> hosts(kHosts.begin(), kHosts.end());
  hosts.push_back(kBase);
  for (const std::string_view host : hosts)
    ears_.push_back(
        std::make_unique<Ears>(host, fleet_->socket(std::string(host)),
                               [this](std::size_t stream, const tims::MessageView& message,
                                      Time at) { notes_.take(stream, message, at); }));
  if (!std::ranges::all_of(ears_, &Ears::is_real_time))
    say("without the right to real-time priorities: what is measured is late, too");
}

// Its router may not have told the others of it yet.
void Scenario::ask(std::string_view component,
                   const std::function<Result<void>(Proxy&)>& question) {
  Proxy proxy(work(), address_of(component), {.on = 5s});
  std::string why;
  const bool done = await(kScenarioPatience, [&] {
    const auto answer = question(proxy);
    if (!answer) why = answer.error().message();
    return answer.ok();
  });
  if (!done) throw Failure(Exit::kNo, "refused", why, "its log: timsctl log follow");
}

void Scenario::turn_on(std::string_view component) { ask(component, &Proxy::on); }

// From the next ON of each.
void Scenario::record_all() {
  for (const std::string_view component : kRecorded) {
    Parameter record{.type = Parameter::kString};
    (void)record.name.assign("record");
    (void)record.valueString.assign(recording_of(component));
    ask(component, [&](Proxy& proxy) { return proxy.set_param(record); });
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
    throw Failure(Exit::kNo, "no_path", "Path(1/0) sends no path", "its log");
  if (!await(kScenarioPatience, [&] { return notes_.truth().at != Time{}; }))
    throw Failure(Exit::kNo, "no_world", "World(1/0) tells no truth", "its log, at the base");
  begin_round();
  turn_on("Mcl(1/0)");
  ChassisProxy chassis(work(), address_of("Chassis(1/0)"));
  timsctl::value_or_fail(chassis.set_active_pilot(address_of("Pilot(1/0)")), "Chassis(1/0)");
  turn_on("Pilot(1/0)");
  if (!drives_within(kScenarioPatience))
    throw Failure(Exit::kNo, "no_drive", "she does not begin to drive",
                  "timsctl component data Pilot/1/0");
  say("she drives");
}

// She is put there, and somebody says so.
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
  const auto place = place_on(path.splines, notes_.truth().pose);
  return !place || rest_of(path.splines, *place) < rest;
}

void Scenario::keep_driving(double rest) {
  if (!is_near_end(rest) && drives_within(3s)) return;
  say("    another round");
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
    throw Failure(Exit::kNo, "no_drive", "she does not drive another round: " + where_she_is(),
                  "--logs FOLDER keeps what all programs say");
  if (!counts) return;
  pause(kSettles);
  notes_.begin_span();
}

std::string Scenario::where_she_is() const {
  const Pose truth = notes_.truth().pose;
  const Position3d known = notes_.position().pos;
  const auto pilot = notes_.newest_pilot();
  return fmt::format("she is at {:.0f} {:.0f} mm, thinks at {} {} mm; her pilot's state is {}",
                     truth.x, truth.y, known.x.raw(), known.y.raw(), pilot ? pilot->state : 0);
}

// Where she was and where she believed to be, to be drawn: timsctl nav plot.
std::string Scenario::drive_csv() const {
  std::string text =
      "time_s,truth_x_m,truth_y_m,position_x_m,position_y_m,position_error_m,path_error_m,"
      "speed_mps\n";
  const PathData path = notes_.path();
  for (const PositionNote& note : notes_.positions(driving_since_)) {
    const Pose& truth = note.truth.pose;
    const auto place = place_on(path.splines, truth);
    text += fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f}\n",
                        std::chrono::duration<double>(note.at - began_).count(), truth.x / 1000,
                        truth.y / 1000, note.pose.x / 1000, note.pose.y / 1000, note.error() / 1000,
                        place ? place->across / 1000 : 0, note.truth.speed / 1000);
  }
  return text;
}

// When, where, and how fast she was.
std::string Scenario::other_contacts() const {
  std::string text;
  const std::vector<TruthNote> truths = notes_.truths(driving_since_);
  for (std::size_t i = 1; i < truths.size(); ++i) {
    const TruthNote& before = truths[i - 1];
    const TruthNote& now = truths[i];
    if (now.walls == before.walls && now.people == before.people) continue;
    text += fmt::format("{}{} at {:.1f} s, {:.0f} {:.0f} mm, {:.0f} mm/s", text.empty() ? "" : "; ",
                        now.walls != before.walls ? "a wall" : "somebody",
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
  say(fmt::format("(a) periods, for {:.0f} s", std::chrono::duration<double>(length).count()));
  notes_.begin_span();
  pause(length);  // and on, while there are posts
}

void Scenario::judge_periods(const Reference& reference) {
  judge_means(reference.timer);
  for (std::size_t i = 0; i < kComponents; ++i) {
    const Stream& stream = kStreams.at(i);
    if (is_short() && stream.period_ms >= milliseconds(kSlowPeriods))
      rows_.push_back(left_out("a", "period of " + std::string(stream.component),
                               "needs --for 45s: too few of its periods"));
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
  say(fmt::format("(f) the router of {} is killed", host));
  const Time killed = fleet_->kill_router(std::string(host));
  std::optional<PilotNote> stop;
  await(kStopsMax, [&] {
    stop = notes_.pilot(killed, [](const PilotNote& pilot) { return pilot.speed == 0; });
    return stop.has_value();
  });
  if (stop) stops_ms_.push_back(milliseconds(stop->at - killed));
  say(stop ? fmt::format("    told to stand after {:.0f} ms", stops_ms_.back())
           : std::string("    she goes on"));
  if (!stop) stops_ms_.push_back(milliseconds(kStopsMax));
  const Time returned = tims::os::now();
  fleet_->sim({"start", std::string(host)});
  const auto back = drives_within(2 * kScenarioPatience / 3, returned);
  returns_ms_.push_back(milliseconds(back.value_or(2 * kScenarioPatience / 3)));
  say(back
          ? fmt::format("    on her way again {:.1f} s after its return", returns_ms_.back() / 1000)
          : std::string("    she stays where she is"));
}

// --- the rest

bool Scenario::await(Duration limit, const std::function<bool()>& so) {
  const Time end = tims::os::now() + limit;
  for (;;) {
    if (so()) return true;
    if (tims::os::now() >= end) return false;
    for (const auto& ears : ears_) ears->keep();
    if (load_) load_->keep();
    signals_.sleep_until(std::min(end, tims::os::now() + kStep));
  }
}

void Scenario::pause(Duration length) {
  (void)await(length, [] { return false; });
}

Duration Scenario::elapsed() const { return tims::os::now() - began_; }

void Scenario::say(const std::string& text) const {
  if (settings_.quiet) return;
  fmt::print("{:7.2f}  {}\n", std::chrono::duration<double>(elapsed()).count(), text);
  std::fflush(stdout);
}

}  // namespace rack::dora
