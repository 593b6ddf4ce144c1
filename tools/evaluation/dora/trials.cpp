// The trials of a run: obstacles in front of the robot, an unplugged laser, a robot that is carried
// away, and the replay of recordings.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "components/pilot/pilot_replay.h"
#include "os/clock.h"
#include "rack/clock.h"
#include "rack/devices/recording.h"
#include "rack/proxies/generic.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/evaluation/dora/cross_track.h"
#include "tools/evaluation/dora/scenario.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;

constexpr double kFront = 1150;        // from the reference point to the front of the hull, mm
constexpr double kPost = 250;          // radius, mm
constexpr double kTight = 600;         // gap to a post that requires MOVE 0 at once, mm
constexpr double kDecelerates = 2000;  // mm/s2
constexpr double kAccelerates = 1000;  // mm/s2
// Total delay of one scan, the pilot, the chassis and its lag, and the age of the true state (20
// ms), s.
constexpr double kReaction = 0.25;
constexpr double kMargin = 200;           // kept by the robot, mm
constexpr double kMore = 500;             // range of distances beyond the stopping distance, mm
constexpr double kSlow = 400;             // mm/s
constexpr double kWalks = 900;            // mm/s
constexpr Duration kTakesNotice = 300ms;  // until the robot reacts to a post
constexpr Duration kLoads = 2s;           // until the pictures arrive
constexpr double kStraysMax = 4000;  // kept free between an obstacle and the end of the path, mm
constexpr Duration kTrialsPatience = 20s;
constexpr Duration kSearches =
    60s;  // about twelve scans, one a second, until localisation doubts its pose
constexpr double kStandsStill = 60;         // mm/s: the robot creeps up to its margin
constexpr double kFast = 3000;              // mm/s
constexpr double kCarried = 20000;          // mm
constexpr double kGetsFast = 24000;         // mm, driven in 6 s
constexpr double kFound = 500;              // largest error of a pose that counts as found, mm
constexpr Duration kNotices = 600ms;        // reports of Position from before the robot was carried
constexpr Duration kRight = 500ms;          // all positions in this time must be right
constexpr Duration kKnowsNothing = 1200ms;  // the period of Mcl and its computing time

}  // namespace

// --- obstacles: (b) and (c)

// Places a post on the path, `ahead` mm in front of the reference point. Returns its id.
std::optional<i32> Scenario::put_post(double ahead) {
  const PathData path = notes_.path();
  const TruthNote truth = notes_.truth();
  const auto place = project_onto(path.splines, truth.pose);
  if (!place || remaining_length(path.splines, *place) < ahead + kStraysMax) return {};
  const Pose at = ahead_of(path.splines, *place, ahead);
  const Pose seen = at - truth.pose;
  notes_.look_at(seen.x, seen.y, kPost + kReaction * truth.speed + 400);
  WorldObstacle post{.radius = static_cast<i32>(kPost)};
  post.pos = {.x = whole_millimetres(at.x), .y = whole_millimetres(at.y)};
  const auto put = WorldProxy(base(), world()).put(post);
  if (!put) return {};
  return put->id;
}

void Scenario::remove_post(i32 id) {
  WorldProxy world_proxy(base(), world());
  await(kTrialsPatience, [&] { return world_proxy.remove(id).ok(); });
}

// (b): a post appears right in front of the slow robot.
void Scenario::step_before_her(std::vector<double>& reactions) {
  const auto is_slow = [&] {
    const double speed = notes_.truth().speed;
    return speed > kSlow && speed < kWalks;
  };
  if (!await(kTrialsPatience, is_slow)) return;
  const TimeStamp put_at = time_stamp();
  const Time since = tims::os::now();
  const u32 contacts = notes_.truth().posts;
  const auto post = put_post(kFront + kPost + kTight);
  if (!post) return;
  std::optional<ScanNote> seen;
  std::optional<PilotNote> stop;
  await(1s, [&] {
    seen = notes_.seen(put_at);
    stop = notes_.pilot(since, [](const PilotNote& pilot) { return pilot.speed == 0; });
    return seen && stop;
  });
  if (seen && stop) {
    // The reaction time starts with the recording time of the scan, not with its arrival.
    const auto age = wall_of(stop->at) - seen->recorded;
    reactions.push_back(static_cast<double>(age.count()));
  } else if (seen) {
    reactions.push_back(1000);
  }
  stand_and_remove(*post, contacts);
}

// (c): at a random speed, a post appears just beyond the stopping distance. Low speeds are more
// likely, because the robot reaches them more often.
void Scenario::appear_before_her() {
  const double part = random_.uniform();
  const double target = kSlow + part * part * (kFast + 500 - kSlow);
  await(5s, [&] { return notes_.truth().speed > target; });
  const TruthNote truth = notes_.truth();
  if (truth.speed < kSlow) return;
  // The robot may accelerate until it reacts.
  const double then = truth.speed + kReaction * kAccelerates;
  const double stops_in = then * kReaction + then * then / (2 * kDecelerates);
  const auto post = put_post(kFront + kPost + stops_in + kMargin + random_.uniform() * kMore);
  if (post) stand_and_remove(*post, truth.posts);
}

void Scenario::stand_and_remove(i32 post, u32 contacts_before) {
  ++posts_;
  const Time since = tims::os::now();
  await(5s, [&] {
    return tims::os::now() - since > kTakesNotice && notes_.truth().speed < kStandsStill;
  });
  if (const u32 more = notes_.truth().posts - contacts_before; more > 0) {
    contacts_ += more;
    print_progress("    the robot has touched a post");
  }
  remove_post(post);
}

void Scenario::try_obstacles(Time until, std::vector<double>& reactions) {
  print_progress("(b) (c) posts in front of the robot");
  const Time since = tims::os::now();
  const int posts_before = posts_;
  do {
    keep_driving();
    if (notes_.truth().speed < kWalks) step_before_her(reactions);
    appear_before_her();
  } while (tims::os::now() < until);
  obstacles_for_ += tims::os::now() - since;
  print_progress(
      fmt::format("    {} posts, {} of them right in front of the robot; {} contacts so far",
                  posts_ - posts_before, reactions.size(), contacts_));
}

void Scenario::try_obstacles_under_load(Duration length) {
  print_progress("(b) under load: pictures of 1 MiB and a recording to the base");
  try {
    load_.emplace(*subscriptions_.back());
  } catch (const timsctl::Failure& failure) {
    no_load_ = failure.message;
    print_progress("    not possible: " + no_load_);
    return;
  }
  pause(kLoads);
  try_obstacles(tims::os::now() + length, loaded_reactions_ms_);
  load_->end();
}

// --- (g)

void Scenario::pull_out_her_eyes() {
  keep_driving();
  await(6s, [&] { return notes_.truth().speed > kFast; });
  print_progress("(g) the laser is unplugged and plugged in again");
  WorldProxy world_proxy(base(), world());
  const Time pulled = tims::os::now();
  timsctl::value_or_fail(world_proxy.plug("dora", "laser", false), "World(1/0)");
  std::optional<PilotNote> stop;
  await(2s, [&] {
    stop = notes_.pilot(pulled, [](const PilotNote& pilot) { return pilot.speed == 0; });
    return stop.has_value();
  });
  unplugged_ms_.push_back(stop ? milliseconds(stop->at - pulled) : 2000);
  pause(2s);
  const Time plugged = tims::os::now();
  timsctl::value_or_fail(world_proxy.plug("dora", "laser", true), "World(1/0)");
  const auto back = drives_within(kTrialsPatience, plugged);
  plugged_ms_.push_back(milliseconds(back.value_or(kTrialsPatience)));
  print_progress(fmt::format("    MOVE 0 after {:.0f} ms; drives {:.0f} ms after the laser is back",
                             unplugged_ms_.back(), plugged_ms_.back()));
}

// --- (e)

void Scenario::carry_her_away() {
  keep_driving(kGetsFast + kCarried + 2 * kStraysMax);
  await(6s, [&] { return notes_.truth().speed > kFast; });
  const PathData path = notes_.path();
  const TruthNote before = notes_.truth();
  const auto place = project_onto(path.splines, before.pose);
  if (!place || remaining_length(path.splines, *place) < kCarried + 2 * kStraysMax) {
    rows_.push_back(
        left_out("e", "carried away", "the robot was too near to the end of its round"));
    return;
  }
  print_progress("(e) the robot is carried 20 m along its path");
  const Pose there = ahead_of(path.splines, *place, kCarried);
  const Time carried = tims::os::now();
  timsctl::value_or_fail(WorldProxy(base(), world())
                             .place("dora", {.x = whole_millimetres(there.x),
                                             .y = whole_millimetres(there.y),
                                             .rho = static_cast<f32>(there.rho)}),
                         "World(1/0)");
  std::optional<PilotNote> held;
  std::optional<Time> first_right;  // the first report of the right position
  std::optional<Time> found;
  await(kSearches, [&] {
    if (!held) held = notes_.pilot(carried, [](const PilotNote& note) { return note.speed == 0; });
    const auto errors = notes_.position_errors(tims::os::now() - kRight);
    if (errors.empty() || tims::os::now() - carried <= kNotices) return false;
    if (!first_right && errors.back() < kFound) first_right = tims::os::now();
    if (std::ranges::max(errors) < kFound) found = tims::os::now();
    return found.has_value();
  });
  const double driven = (notes_.truth().travelled - before.travelled) / 1000;
  rows_.push_back(judge_fact(
      "e", "carried 20 m away: localised again", "within 30 m",
      found ? fmt::format("after {:.1f} m, {:.1f} s", driven, milliseconds(*found - carried) / 1000)
            : fmt::format("not within {:.0f} s", milliseconds(kSearches) / 1000),
      found && driven <= 30, "the log of Mcl(1/0)"));
  const bool at_once = first_right && *first_right - carried <= kKnowsNothing;
  rows_.push_back(
      judge_fact("e", "carried away: the pilot stops", "it stops",
                 held      ? fmt::format("after {:.1f} s", milliseconds(held->at - carried) / 1000)
                 : at_once ? std::string("localised again before the loss could be noticed")
                           : std::string("it continues to drive"),
                 held || at_once, "deviationMax of Pilot(1/0); the log of Mcl(1/0)"));
  print_progress(found ? "    localised again" : "    not localised again");
}

void Scenario::drive_by_satellites(Duration length) {
  keep_driving();
  print_progress("(e) satellites only");
  Proxy mcl(work(), address_of("Mcl(1/0)"));
  Proxy pilot(work(), address_of("Pilot(1/0)"));
  (void)mcl.off();
  (void)pilot.set_param(integer_parameter("deviationMax", 0));
  pause(5s);  // until the position without the laser has degraded
  const Time since = tims::os::now();
  pause(length);
  satellite_errors_ = notes_.position_errors(since);
  turn_on("Mcl(1/0)");
  await(kTrialsPatience, [&] {
    const PositionData now = notes_.position();
    return now.var.x < 500 && now.var.y < 500;
  });
  (void)pilot.set_param(integer_parameter("deviationMax", 1000));
}

// --- (i)

// Replays the recordings of the pilot and the drivers: the pilot must decide, and the drivers must
// decode, the same again.
void Scenario::replay_all() {
  print_progress("(i) the recordings of the pilot and the drivers are replayed");
  for (const std::string_view component : kRecorded) {
    Proxy proxy(work(), address_of(component));
    (void)proxy.off();
    await(kTrialsPatience, [&] {
      const auto status = proxy.status();
      return status && *status == Status::kDisabled;
    });
  }
  replay_her_pilot();
  for (const std::string_view component : kRecorded)
    if (component != kPilot) replay_driver(component);
}

void Scenario::replay_her_pilot() {
  pilot::PilotReplay replay;
  const auto read = device::read_recording(
      recording_of(kPilot),
      [&](const device::CaptureRecord& record) { return replay.take(record); });
  rows_.push_back(judge_fact(
      "i", "the recording of the pilot, replayed", "the same MOVE, bit for bit",
      fmt::format("{} decisions, {} different, {} not reproducible", replay.decisions(),
                  replay.different(), replay.undecided()),
      read && replay.decisions() > 0 && replay.different() + replay.undecided() == 0,
      replay.first_difference() ? replay.first_difference()->text
                                : "the log of Pilot(1/0): which records could not be written"));
}

// Runs the program of the component with its current parameters and --replay.
void Scenario::replay_driver(std::string_view component) {
  ParameterList list;
  await(kTrialsPatience, [&] {
    auto got = Proxy(work(), address_of(component)).get_param();
    if (got) list = std::move(*got);
    return got.ok();
  });
  tims::os::Command command;
  for (const Parameter& parameter : list.parameters) {
    if (command.empty()) {
      command.emplace_back(parameter.valueString.view());  // the first parameter is the program
      continue;
    }
    std::string value = std::to_string(parameter.valueInt);
    if (parameter.type == Parameter::kString) value = parameter.valueString.view();
    if (parameter.type == Parameter::kFloat) value = fmt::format("{}", parameter.valueFloat);
    command.push_back(fmt::format("--{}={}", parameter.name.view(), value));
  }
  command.push_back("--replay=" + recording_of(component));
  const auto ran = timsctl::run({.command = command});
  std::string output = ran.output.substr(0, ran.output.find_last_not_of('\n') + 1);
  const std::size_t last = output.rfind('\n') + 1;  // the differences come first
  rows_.push_back(judge_fact(
      "i", fmt::format("the recording of {}, replayed", component), "the same data, bit for bit",
      output.substr(last), ran.status.success(),
      last == 0 ? fmt::format("the log of {}: which records could not be written", component)
                : output.substr(0, last - 1)));
}

// --- (d), and (e) with the laser

void Scenario::note_cross_track_errors(Time since) {
  const PathData path = notes_.path();
  for (const TruthNote& note : notes_.truths(since)) {
    if (note.speed < kFast) continue;
    const auto place = project_onto(path.splines, note.pose);
    if (place) lateral_mm_.push_back(std::abs(place->across));
  }
  const auto errors = notes_.position_errors(since);
  position_mm_.insert(position_mm_.end(), errors.begin(), errors.end());
}

}  // namespace rack::dora
