#include "tools/timsctl/nav_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "components/geometry/pose.h"
#include "components/path/polar_spline.h"

namespace timsctl {

using namespace std::chrono_literals;

namespace {

constexpr double kSpreadMax = 0.5;  // m; above it MonteCarloLocalisation publishes no position
constexpr double kApartMax = 0.5;   // m
constexpr double kAgeMax = 2;       // s
constexpr double kAhead = -0.5;     // s; tolerance for unsynchronised clocks
constexpr tims::Duration kSilence = 2s;
// A pilot that was restarted has no destination until its path component sends the path again.
constexpr tims::Duration kRestart = 10s;
constexpr double kTurned =
    0.015;  // rad between two reports; more than corrections of localisation at rest

MissingPart localiser_missing(const WhereFacts& facts) {
  if (facts.mcl.empty())
    return {"nothing corrects the odometry: there is no MonteCarloLocalisation",
            "start it with a map: docs/operating.md, \"Send a robot to a place\""};
  if (facts.mcl_state != "on" && !facts.mcl_has_map)
    return {fmt::format("{} is {} and has no map", facts.mcl, facts.mcl_state),
            fmt::format("`timsctl nav map load FILE`, then `timsctl component on {}`", facts.mcl)};
  if (facts.mcl_state != "on")
    return {fmt::format("{} is {}", facts.mcl, facts.mcl_state),
            fmt::format("`timsctl component on {}`", facts.mcl)};
  return {
      fmt::format("{} does not send its pose to the position component", facts.mcl),
      fmt::format("`timsctl component param set {} positionInst 0`, then off and on", facts.mcl)};
}

}  // namespace

Samples samples_of(const rack::MclData& data) {
  Samples samples;
  double x = 0;
  double y = 0;
  double squares = 0;
  for (const rack::MclDataPoint& point : data.points) {
    if (point.type != rack::mcl_point::kSample) continue;
    ++samples.count;
    x += point.x.si();
    y += point.y.si();
    squares += point.x.si() * point.x.si() + point.y.si() * point.y.si();
  }
  if (samples.count == 0) return samples;
  const auto n = static_cast<double>(samples.count);
  samples.spread_m = std::sqrt(std::max(0.0, squares / n - (x / n) * (x / n) - (y / n) * (y / n)));
  return samples;
}

std::vector<MissingPart> missing(const WhereFacts& facts) {
  std::vector<MissingPart> found;
  if (facts.position_state != "on")
    found.push_back({fmt::format("{} is {}", facts.position, facts.position_state),
                     fmt::format("`timsctl component on {}`", facts.position)});
  const bool localises = !facts.mcl.empty() && facts.mcl_state == "on" && facts.mcl_sends_pose;
  // Outdoors a satellite receiver is sufficient.
  if (!localises && !(facts.mcl.empty() && facts.has_gps))
    found.push_back(localiser_missing(facts));
  const bool unsure = localises && facts.samples && facts.samples->spread_m > kSpreadMax;
  if (unsure)
    found.push_back(
        {fmt::format("{} has not converged: its samples are spread over {:.1f} m", facts.mcl,
                     facts.samples->spread_m),
         "drive some metres (PilotJoystick, PilotWallFollowing), or set the start pose: "
         "startX, startY, startRho"});
  if (localises && !unsure && facts.apart_m && *facts.apart_m > kApartMax)
    found.push_back(
        {fmt::format("{} and {} are {:.1f} m apart", facts.position, facts.mcl, *facts.apart_m),
         "does the map match? `timsctl nav map show --plot FILE`"});
  if (facts.age_s && *facts.age_s > kAgeMax)
    found.push_back({fmt::format("the newest data are {:.1f} s old", *facts.age_s),
                     "is its odometry on? `timsctl component list`"});
  if (facts.age_s && *facts.age_s < kAhead)
    found.push_back(
        {fmt::format("its clock is {:.1f} s ahead of the clock of this host", -*facts.age_s),
         "`timsctl clock` compares the clocks of all routers"});
  return found;
}

std::string_view name(DriveState state) {
  constexpr std::array<std::string_view, 12> kNames = {
      "planning", "driving", "turning", "standing", "making_room", "waiting",
      "silent",   "arrived", "no_way",  "off_path", "dropped",     "blocked"};
  return kNames[static_cast<std::size_t>(state)];
}

DriveState DriveWatch::take(const rack::PilotStatusData& status, tims::Time now,
                            std::span<const rack::PolarSpline> ahead) {
  const DriveState state = judge(status, now, ahead);
  // The path component ends making room and waiting by itself.
  if (state == DriveState::kDriving || state == DriveState::kTurning ||
      state == DriveState::kMakesRoom || state == DriveState::kWaitsAside || idle_since_)
    moved_ = now;
  return !is_end(state) && now - moved_ >= patience_ ? DriveState::kBlocked : state;
}

DriveState DriveWatch::judge(const rack::PilotStatusData& status, tims::Time now,
                             std::span<const rack::PolarSpline> ahead) {
  if (status.recordingTime != newest_) {
    newest_ = status.recordingTime;
    changed_ = now;
    const auto heading = static_cast<double>(status.pos.rho);
    turned_ = fresh_ && std::abs(rack::signed_angle(heading - heading_)) > kTurned;
    heading_ = heading;
    fresh_ = true;
  }
  if (now - changed_ >= kSilence) return DriveState::kSilent;
  if (!fresh_) return DriveState::kPlanning;
  const bool idle = status.pilotState == rack::pilot_state::kIdle;
  if (!idle) idle_since_.reset();
  switch (status.pilotState) {
    case rack::pilot_state::kIdle:
      if (status.distanceToDest == 0) return DriveState::kArrived;
      if (!idle_since_) idle_since_ = now;
      return now - *idle_since_ >= kRestart ? DriveState::kDropped : DriveState::kPlanning;
    case rack::pilot_state::kPlanning:
      return DriveState::kPlanning;
    case rack::pilot_state::kRunning:
      drove_ = true;
      if (!ahead.empty() && rack::path::is_waiting(ahead.front())) return DriveState::kWaitsAside;
      if ((status.speed != 0 || turned_) && std::ranges::any_of(ahead, rack::path::is_waiting))
        return DriveState::kMakesRoom;
      if (status.speed != 0) return DriveState::kDriving;
      return turned_ ? DriveState::kTurning : DriveState::kStanding;
    default:
      return drove_ ? DriveState::kAstray : DriveState::kNoPath;
  }
}

std::string obstacle_text(const rack::Scan2dData& scan, const rack::ChassisParamData& hull) {
  struct Nearest {
    double distance = kNearby;
    std::string_view where{};
  };
  Nearest ahead;
  Nearest any;
  for (const rack::ScanPoint& point : scan.points) {
    constexpr rack::i32 kNothing = rack::scan_point::kInvalid | rack::scan_point::kMaxRange;
    if ((point.type & kNothing) != 0) continue;
    const double front = point.x.si() - hull.boundaryFront.si();
    const double back = -point.x.si() - hull.boundaryBack.si();
    const double right = point.y.si() - hull.boundaryRight.si();
    const double left = -point.y.si() - hull.boundaryLeft.si();
    const double along = std::max({0.0, front, back});
    const double across = std::max({0.0, right, left});
    const double distance = std::hypot(along, across);
    if (across == 0 && front > 0 && distance < ahead.distance) ahead = {distance, "ahead"};
    if (distance >= any.distance) continue;
    any = {distance, across > along ? (right > 0 ? "to the right" : "to the left")
                                    : (front > 0 ? "ahead" : "behind")};
  }
  constexpr double kFarther = 0.3;  // what is much nearer beside it holds it back
  const bool is_ahead = !ahead.where.empty() && ahead.distance < any.distance + kFarther;
  const Nearest& named = is_ahead ? ahead : any;
  if (named.where.empty()) return {};
  return fmt::format("an obstacle is {:.2f} m {}", named.distance, named.where);
}

PathSummary summary_of(std::span<const rack::PolarSpline> splines) {
  constexpr int kSteps = 50;  // integration steps per spline; the speed is not constant
  PathSummary sum;
  for (const rack::PolarSpline& spline : splines) {
    sum.length_m += std::abs(spline.length.si());
    const double step = rack::path::size(spline) / kSteps;
    for (int i = 0; i < kSteps; ++i)
      if (const double speed = rack::path::speed_at(spline, (i + 0.5) * step); speed > 0)
        sum.seconds += step / speed;
  }
  return sum;
}

}  // namespace timsctl
