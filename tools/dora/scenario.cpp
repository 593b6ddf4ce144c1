#include "tools/dora/scenario.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "rack/proxies/chassis.h"
#include "tools/cli/failure.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;
using timsctl::Exit;
using timsctl::Failure;

constexpr Duration kStep = 20ms;
constexpr Duration kPatience = 30s;
constexpr Duration kSettles = 2s;      // after something was done to her, until she is as before
constexpr Duration kPeriodsMin = 10s;  // below, a period of 2 s says nothing
constexpr Duration kStopsMax = 2s;     // waited for
constexpr double kStopMs = 200;        // (f)
constexpr double kReturnMs = 5000;     // (f)
constexpr i32 kDrives = 300;           // mm/s

double milliseconds(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

tims::Address address(std::string_view component) { return *tims::Address::parse(component); }

}  // namespace

Scenario::Scenario(const Settings& settings, const timsctl::Signals& signals)
    : settings_(settings),
      signals_(signals),
      began_(tims::os::now()),
      name_(fmt::format("dora{}", ::getpid() % 100000)),
      log_(std::filesystem::temp_directory_path() / (name_ + ".log")) {}

Scenario::~Scenario() {
  ears_.clear();
  fleet_.reset();
  std::error_code ignored;
  std::filesystem::remove(log_, ignored);
}

Outcome Scenario::run() {
  ReferenceTimer timer;
  bring_up();
  begin_to_drive();
  measure_periods(std::max(kPeriodsMin, settings_.length * 3 / 10));
  kill_routers();
  Outcome outcome{.rows = {}, .timer = timer.end()};
  const TimerQuality& quality = outcome.timer;
  judge_periods(quality);
  rows_.push_back(judge_latency({.check = "f",
                                 .what = "a host's router is killed: she is told to stand",
                                 .look = "the pilot's log: what it missed, and when",
                                 .max_ms = kStopMs},
                                stops_ms_, quality));
  rows_.push_back(judge_latency({.check = "f",
                                 .what = "the router is back: she goes on by herself",
                                 .look = "timsctl component list, and who has not come back",
                                 .max_ms = kReturnMs},
                                returns_ms_, quality));
  const std::vector<std::string> ended = fleet_->ended();
  rows_.push_back(judge_fact("f", "no program ends by itself", "0", std::to_string(ended.size()),
                             ended.empty(), ended.empty() ? "" : ended.front()));
  std::ranges::stable_sort(rows_, {}, &Row::check);
  outcome.rows = std::move(rows_);
  return outcome;
}

// --- the fleet, and that she drives

void Scenario::bring_up() {
  say("the fleet: " + settings_.fleet_file);
  fleet_.emplace(timsctl::sim::RunningFleet::Options{
      .name = name_, .file = settings_.fleet_file, .log = log_});
  for (const std::string_view host : kHosts)
    ears_.push_back(
        std::make_unique<Ears>(host, fleet_->socket(std::string(host)),
                               [this](std::size_t stream, const tims::MessageView& message,
                                      Time at) { notes_.take(stream, message, at); }));
  if (!std::ranges::all_of(ears_, &Ears::is_real_time))
    say("without the right to real-time priorities: what is measured is late, too");
}

void Scenario::turn_on(std::string_view component) {
  Proxy proxy(work(), address(component), {.on = 5s});
  std::string why;
  const bool on = await(kPatience, [&] {
    const auto done = proxy.on();
    if (!done) why = done.error().message();
    return done.ok();
  });
  if (!on) throw Failure(Exit::kNo, "not_on", why, "its log: timsctl log follow");
}

void Scenario::begin_to_drive() {
  for (const std::string_view component : {"Chassis(1/0)", "Gyro(1/0)", "Gps(1/0)", "Path(1/0)"})
    turn_on(component);
  if (!await(kPatience, [&] { return !notes_.path().splines.empty(); }))
    throw Failure(Exit::kNo, "no_path", "Path(1/0) sends no path", "its log");
  // She stands at the beginning of her round: somebody has to say so.
  const Position2d start = notes_.path().splines.front().startPos;
  PositionProxy position(work(), address("Position(1/0)"));
  const auto now = position.get_data();
  PositionData known = timsctl::value_or_fail(now, "Position(1/0)");
  known.pos = {.x = start.x, .y = start.y, .rho = start.rho};
  known.var = {.x = 300, .y = 300, .rho = 0.05F};
  timsctl::value_or_fail(position.update(known), "Position(1/0)");
  turn_on("Mcl(1/0)");
  ChassisProxy chassis(work(), address("Chassis(1/0)"));
  timsctl::value_or_fail(chassis.set_active_pilot(address("Pilot(1/0)")), "Chassis(1/0)");
  turn_on("Pilot(1/0)");
  if (!drives_within(kPatience))
    throw Failure(Exit::kNo, "no_drive", "she does not begin to drive",
                  "timsctl component data Pilot/1/0");
  say("she drives");
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
  pause(length);
  notes_.end_span();
}

void Scenario::judge_periods(const TimerQuality& timer) {
  for (std::size_t i = 0; i < kStreams.size(); ++i)
    rows_.push_back(judge_period(
        {.name = std::string(kStreams.at(i).component), .period_ms = kStreams.at(i).period_ms},
        notes_.spans(i), timer));
}

// --- (f)

void Scenario::kill_routers() {
  for (const std::string_view host : kHosts) kill_router(host);
}

void Scenario::kill_router(std::string_view host) {
  (void)drives_within(kPatience);
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
  const auto back = drives_within(2 * kPatience / 3, returned);
  returns_ms_.push_back(milliseconds(back.value_or(2 * kPatience / 3)));
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
