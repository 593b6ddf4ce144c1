// timsctl nav goto: sends a robot to a position and monitors it until it arrives.
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/text.h"
#include "components/geometry/pose.h"
#include "os/clock.h"
#include "rack/proxies/position.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/nav_report.h"
#include "tools/timsctl/nav_robot.h"

namespace timsctl {

using namespace std::chrono_literals;

namespace {

namespace id = tims::class_id;

constexpr tims::Duration kLookEvery = 200ms;
constexpr tims::Duration kPrintEvery =
    1s;  // interval of progress lines if they cannot be overwritten
constexpr tims::Duration kPatience = 30s;
// Without this program, however it ends, the robot stands after this time.
constexpr rack::Milliseconds<rack::u32> kWatchdog = 3000;
constexpr tims::Duration kWatchEvery = 600ms;
constexpr tims::Duration kNavGotoStopPatience = 5s;
constexpr tims::Duration kStarting = 5s;       // for a robot that is being started
constexpr double kSettled = 1;                 // s without further components: it is complete
constexpr tims::Duration kLocalisation = 10s;  // for a localisation that was just turned on
constexpr double kSure = 500;                  // mm, standard deviation
constexpr double kFar = 2e6;  // m; larger values exceed the range of a message in mm

struct Goal {
  double x = 0;  // m, or degrees north with --gps
  double y = 0;
  std::optional<double> heading{};  // rad
};

double number(const std::string& text, std::string_view what, double most) {
  const auto value = base::parse_number<double>(text);
  if (!value || !(std::abs(*value) <= most))
    throw usage_error(fmt::format("nav goto: \"{}\" is not a {}", text, what),
                      "timsctl nav goto X Y [HEADING], in m and degrees");
  return *value;
}

Goal read_goal(const Options& options) {
  const auto& arguments = options.arguments;
  Goal goal;
  goal.x = number(arguments[0], options.gps ? "latitude" : "x in m", options.gps ? 90 : kFar);
  goal.y = number(arguments[1], options.gps ? "longitude" : "y in m", options.gps ? 180 : kFar);
  if (arguments.size() > 2)
    goal.heading = rack::radians(number(arguments[2], "heading in degrees", 3600));
  return goal;
}

class Drive {
 public:
  Drive(Context& context, NavRobot& robot) : context_(context), robot_(robot) {
    for (const tims::Address candidate : robot.all(id::kPilot)) {
      const auto parameters = robot.client().parameters(candidate);
      const auto path = robot.linked(parameters, "path", id::kPath);
      if (!path) continue;
      pilot_ = candidate;
      path_ = *path;
      chassis_ = robot.linked(parameters, "chassis", id::kChassis);
      position_ = robot.linked(parameters, "position", id::kPosition);
      scan_ = robot.linked(parameters, "scan2d", id::kScan2d);
      break;
    }
    if (!chassis_ || !position_)
      throw Failure(Exit::kNoSuch, "no_pilot", robot.title() + " has no pilot that follows a path",
                    "start PilotPath and PathRDDF: docs/operating.md, \"Send a robot to a place\"");
  }

  // Turns on everything that is needed, and turns off the pilot that was driving.
  void prepare() {
    localise();
    robot_.need_on(*chassis_);
    release_other_pilot();
    const rack::ChassisSetActivePilotData request{pilot_};
    need_ok(robot_.client().ask(*chassis_, rack::ChassisType::kSetActivePilot, request),
            robot_.name(*chassis_) + " does not accept the pilot " + robot_.name(pilot_),
            "is it on?");
    robot_.need_on(pilot_);
    if (!context_.options.anyway) need_sure_position();
    const Message hull = robot_.client().ask(*chassis_, rack::ChassisType::kGetParameter);
    if (hull.header.type == rack::ChassisType::kParameter)
      hull_ =
          value_or_fail(rack::decode<rack::ChassisParamData>(hull.view()), robot_.name(*chassis_));
    hold(false);
  }

  rack::PilotDestData destination(const Goal& goal) {
    rack::PositionData at;
    if (context_.options.gps) {
      if (!knows_earth(robot_.client().parameters(*position_)))
        throw Failure(
            Exit::kNo, "no_origin",
            robot_.name(*position_) + " does not know the geographic position of its origin",
            "set its parameters positionReference and offsetNorthing ..., or autoOffset with a "
            "satellite receiver");
      const rack::PositionWgs84Data request{rack::radians(goal.x), rack::radians(goal.y), 0, 0};
      const Message answer =
          robot_.client().ask(*position_, rack::PositionType::kWgs84ToPos, request);
      if (answer.header.type != rack::PositionType::kPos)
        need_ok(answer, robot_.name(*position_) + " cannot convert the geographic position",
                "check its parameters positionReference, offset..., autoOffset");
      at = value_or_fail(rack::decode<rack::PositionData>(answer.view()), robot_.name(*position_));
    } else {
      at.pos.x = rack::whole_millimetres(goal.x * 1000);
      at.pos.y = rack::whole_millimetres(goal.y * 1000);
    }
    rack::PilotDestData request;
    request.pos.x = at.pos.x;
    request.pos.y = at.pos.y;
    // Without a heading, the direction from the present position is used.
    const auto here = robot_.data<rack::PositionData>(*position_);
    const double towards =
        here ? std::atan2(at.pos.y.si() - here->pos.y.si(), at.pos.x.si() - here->pos.x.si()) : 0;
    request.pos.rho = static_cast<rack::f32>(rack::heading(goal.heading.value_or(towards)));
    goal_ = request.pos;
    return request;
  }

  void send(const rack::PilotDestData& request) {
    need_ok(robot_.client().ask(pilot_, rack::PilotType::kSetDestination, request, 10s),
            fmt::format("{} finds no path to {}", robot_.name(pilot_), goal_text()),
            "is the position free, and on the map? `timsctl nav map show --plot FILE`");
  }

  Exit follow() {
    try {
      return look_on();
    } catch (const Interrupted&) {
      context_.signals.forget();
      stop();
      throw;
    } catch (const Failure& failure) {
      if (failure.exit == Exit::kTimeout)
        context_.out.note("the robot may still be driving: `timsctl component off " +
                          robot_.plain_name(pilot_) + "` stops it");
      throw;
    }
  }

  [[nodiscard]] std::string goal_text() const {
    return fmt::format("{}, heading {:.0f} deg", place_text(metres(goal_.x), metres(goal_.y)),
                       rack::degrees(static_cast<double>(goal_.rho)));
  }

 private:
  // Localisation is optional: without it, the odometry alone is used.
  void localise() {
    const auto mcl = robot_.first(id::kMcl);
    if (!mcl || robot_.is_on(*mcl)) return;
    if (const auto why = robot_.turn_on(*mcl))
      context_.out.note(fmt::format("{} remains off; only the odometry determines the position{}",
                                    robot_.name(*mcl), why->empty() ? "" : ": " + *why));
  }

  // A robot that does not know where it is would drive somewhere else.
  void need_sure_position() {
    const tims::Time end = tims::os::deadline_after(kLocalisation);
    for (;;) {
      const auto position = robot_.data<rack::PositionData>(*position_);
      const double deviation =
          position ? std::max(position->var.x.raw(), position->var.y.raw()) : 0;
      if (position && deviation <= kSure) return;
      if (tims::os::now() < end) {
        context_.signals.sleep_until(tims::os::deadline_after(kLookEvery));
        continue;
      }
      if (!position)
        throw Failure(Exit::kNo, "no_position", robot_.name(*position_) + " has no data",
                      "`timsctl nav where` shows what is missing");
      throw Failure(Exit::kNo, "not_sure",
                    fmt::format("{} is not sure where it is: standard deviation {:.1f} m",
                                robot_.title(), deviation / 1000),
                    "`timsctl nav where` shows what is missing; --anyway sends it all the same");
    }
  }

  void release_other_pilot() {
    const auto data = robot_.data<rack::ChassisData>(*chassis_);
    if (!data || data->activePilot == rack::kNoPilot) return;
    const auto& pilots = robot_.all(id::kPilot);
    const bool known = std::ranges::find(pilots, data->activePilot) != pilots.end();
    if (!known || data->activePilot == pilot_ || !robot_.is_on(data->activePilot)) return;
    (void)robot_.client().ask(data->activePilot, tims::type::kOff);
    context_.out.note(robot_.name(data->activePilot) + " was driving; it is off now");
  }

  void hold(bool on) {
    const rack::PilotHoldData request{.holdState = on ? 1 : 0, .holdTime = 0, .pos = {}};
    need_ok(robot_.client().ask(pilot_, rack::PilotType::kHoldCommand, request),
            robot_.name(pilot_) + (on ? " does not stop" : " does not continue"), "is it on?");
  }

  rack::PilotStatusData status() {
    const Message answer = robot_.client().ask(pilot_, rack::PilotType::kGetStatus);
    if (answer.header.type != rack::PilotType::kStatus)
      need_ok(answer, robot_.name(pilot_) + " does not report its status", "is it a PilotPath?");
    return value_or_fail(rack::decode<rack::PilotStatusData>(answer.view()), robot_.name(pilot_));
  }

  Exit look_on() {
    const tims::Time begin = tims::os::now();
    const tims::Time end = context_.run_end();
    DriveWatch watch(status().recordingTime, begin, context_.options.patience.value_or(kPatience));
    for (;;) {
      renew_watchdog(kWatchdog);
      context_.signals.sleep_until(tims::os::deadline_after(kLookEvery));
      const tims::Time now = tims::os::now();
      const rack::PilotStatusData seen = status();
      const auto data = seen.pilotState == rack::pilot_state::kRunning
                            ? robot_.data<rack::PilotData>(pilot_)
                            : std::nullopt;
      std::span<const rack::PolarSpline> ahead;
      if (data) ahead = data->splines;
      const DriveState state = watch.take(seen, now, ahead);
      if (is_end(state)) {
        end_line();
        return finish(state, seen, base::seconds(now - begin));
      }
      print(state, seen, now);
      if (now >= end) {
        end_line();
        stop();
        throw Failure(Exit::kTimeout, "timeout",
                      fmt::format("{} is not at {} yet: {:.2f} m to go", robot_.title(),
                                  goal_text(), rest_m(seen)),
                      "use a longer --for");
      }
    }
  }

  // Pilots that do not have it drive on without it.
  void renew_watchdog(rack::Milliseconds<rack::u32> timeout) {
    const tims::Time now = tims::os::now();
    if (timeout != 0 && now < next_watch_) return;
    next_watch_ = now + kWatchEvery;
    (void)robot_.client().ask(pilot_, rack::PilotType::kWatchdog, rack::PilotWatchdogData{timeout});
  }

  static double rest_m(const rack::PilotStatusData& status) {
    return std::max(0.0, metres(status.distanceToDest));
  }

  void print(DriveState state, const rack::PilotStatusData& status, tims::Time now) {
    const bool in_place = context_.out.terminal() && !context_.out.json();
    if (!in_place && state == printed_ && now - printed_at_ < kPrintEvery) return;
    printed_ = state;
    printed_at_ = now;
    const std::string why = reason(state);
    if (context_.out.json()) {
      json::object line{{"schema", "tims/nav_progress/1"},
                        {"state", name(state)},
                        {"rest_m", rest_m(status)},
                        {"speed_mps", status.speed.si()},
                        {"pose", pose_json(status.pos)}};
      if (!why.empty()) line["why"] = why;
      return context_.out.write(line);
    }
    const std::string text =
        fmt::format("{:<8}  {:6.2f} m to go  {:5.2f} m/s  at {}{}{}", name(state), rest_m(status),
                    status.speed.si(), place_text(metres(status.pos.x), metres(status.pos.y)),
                    why.empty() ? "" : "  ", why);
    context_.out.write(in_place ? "\r\033[K" + text : text + "\n");
    open_line_ = in_place;
  }

  void end_line() {
    if (open_line_) context_.out.write("\n");
    open_line_ = false;
  }

  // Why the robot does not just drive on; empty: it does.
  std::string reason(DriveState state) {
    switch (state) {
      case DriveState::kMakesRoom:
        return "something blocks the path: drives aside, so that a person can pass";
      case DriveState::kWaitsAside:
        return "has made room, and waits until the path is clear";
      case DriveState::kStanding:
      case DriveState::kSilent:
        return what_is_ahead(state);
      default:
        return "";
    }
  }

  std::string what_is_ahead(DriveState state) {
    if (state == DriveState::kSilent) return robot_.name(pilot_) + " is " + robot_.state(pilot_);
    if (!scan_) return "the pilot is stopped";
    const auto scan = robot_.data<rack::Scan2dData>(*scan_);
    if (!scan) return robot_.name(*scan_) + " has no scan";
    const std::string obstacle = obstacle_text(*scan, hull_);
    return obstacle.empty() ? fmt::format("no obstacle is within {} m", kNearby) : obstacle;
  }

  Exit finish(DriveState state, const rack::PilotStatusData& status, double seconds) {
    const double beside =
        std::hypot(metres(status.pos.x) - metres(goal_.x), metres(status.pos.y) - metres(goal_.y));
    if (state == DriveState::kArrived) {
      const json::object done{{"schema", "tims/nav_goto/1"},
                              {"result", name(state)},
                              {"pose", pose_json(status.pos)},
                              {"beside_m", beside},
                              {"seconds", seconds}};
      context_.out.write(done, [&] {
        return fmt::format(
            "arrived at {}, heading {:.1f} deg, position error {:.2f} m, after {:.1f} s\n",
            place_text(metres(status.pos.x), metres(status.pos.y)),
            rack::degrees(static_cast<double>(status.pos.rho)), beside, seconds);
      });
      return Exit::kDone;
    }
    const std::string code(name(state));
    if (state == DriveState::kNoPath)
      throw Failure(Exit::kNo, code,
                    fmt::format("{} found no path to {}", robot_.name(path_), goal_text()),
                    fmt::format("`timsctl log show -c {}` has its messages; `timsctl nav map show "
                                "--plot FILE` draws the free space",
                                robot_.plain_name(path_)));
    if (state == DriveState::kDropped) {
      stop();
      throw Failure(Exit::kNo, code, robot_.name(pilot_) + " no longer has a destination",
                    "it was turned off and on, or another program has sent the robot elsewhere");
    }
    const std::string why = what_is_ahead(DriveState::kStanding);
    stop();
    if (state == DriveState::kAstray)
      throw Failure(Exit::kNo, code,
                    fmt::format("{} has left its corridor, {:.2f} m before the end", robot_.title(),
                                rest_m(status)),
                    "`timsctl nav where`, then send it again");
    throw Failure(Exit::kNo, code,
                  fmt::format("{} is blocked {:.2f} m before the end: {}", robot_.title(),
                              rest_m(status), why),
                  "clear the path and send it again; --patience sets the longest standstill");
  }

  // In any case, the final state of the robot is reported.
  void stop() {
    end_line();
    try {
      hold(true);
    } catch (const Failure&) {
      // A pilot that does not stop may still be turned off.
      const Message answer = robot_.client().ask(pilot_, tims::type::kOff);
      need_ok(answer,
              "the robot may be driving: " + robot_.name(pilot_) + " neither stops nor turns off",
              "use the emergency stop");
      return context_.out.note(robot_.name(pilot_) + " is off, the robot stops");
    }
    renew_watchdog(0);
    const tims::Time deadline = tims::os::deadline_after(kNavGotoStopPatience);
    bool stands = false;
    while (!stands && tims::os::now() < deadline) {
      const auto data = robot_.data<rack::ChassisData>(*chassis_);
      stands = data && std::abs(static_cast<double>(data->vx)) < 1;
      if (!stands) context_.signals.sleep_until(tims::os::deadline_after(kLookEvery / 4));
    }
    context_.out.note(fmt::format("{}: {} is stopped; `timsctl nav goto` continues",
                                  stands ? "the robot stands still" : "the robot is braking",
                                  robot_.name(pilot_)));
  }

  Context& context_;
  NavRobot& robot_;
  tims::Address pilot_;
  tims::Address path_;
  std::optional<tims::Address> chassis_;
  std::optional<tims::Address> position_;
  std::optional<tims::Address> scan_;
  rack::ChassisParamData hull_;
  rack::Position3d goal_;
  tims::Time next_watch_{};
  std::optional<DriveState> printed_;
  tims::Time printed_at_{};
  bool open_line_ = false;
};

// `timsctl up FILE &` returns before all components are registered.
std::unique_ptr<NavRobot> complete_robot(Context& context) {
  const tims::Time deadline = tims::os::deadline_after(kStarting);
  bool is_noted = false;
  for (;;) {
    const bool is_late = tims::os::now() >= deadline;
    std::string why;
    try {
      auto robot = std::make_unique<NavRobot>(context);
      // One that was seen starting has its pilot last.
      const bool is_complete = !is_noted || robot->first(id::kPilot);
      if (is_late || (is_complete && robot->settled_s() >= kSettled)) return robot;
      why = robot->title() + " is being started";
    } catch (const Failure& failure) {
      if (is_late || failure.exit != Exit::kNoSuch) throw;
      why = failure.what();
    }
    if (!std::exchange(is_noted, true)) context.out.note(why + "; waiting");
    context.signals.sleep_until(tims::os::deadline_after(kLookEvery));
  }
}

}  // namespace

Exit nav_goto(Context& context) {
  const Goal goal = read_goal(context.options);
  const auto found = complete_robot(context);
  NavRobot& robot = *found;
  Drive drive(context, robot);
  drive.prepare();
  drive.send(drive.destination(goal));
  if (!context.options.no_wait) return drive.follow();
  context.out.write(json::object{{"schema", "tims/nav_goto/1"}, {"result", "sent"}},
                    [&] { return "sent to " + drive.goal_text() + "\n"; });
  return Exit::kDone;
}

}  // namespace timsctl
