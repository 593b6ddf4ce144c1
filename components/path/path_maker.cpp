#include "components/path/path_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "components/path/rddf.h"

namespace rack::path {

namespace {

constexpr double kSame = 10;                    // mm: waypoints nearer than this are merged
constexpr double kStraight = 0.0005;            // rad: smaller bends are ignored
constexpr double kLongest = 1e9;                // mm, of a leg
constexpr double kRadiusMax = 1e8;              // mm: from here on, straight
constexpr double kPathMakerDirectionOnly = 10;  // mm/s: of a lower speed only the sign counts
constexpr double kWorthwhile = 100;  // mm, minimum radius for a vehicle that turns at rest
constexpr double kAmple = 2;         // factor on the radius that the speed requires

struct Point {
  double x = 0;
  double y = 0;
};

// The leg to a waypoint.
struct Leg {
  Point from;
  Point to;
  double sense = 1;                 // -1: backward
  double heading = 0;               // of the vehicle
  double length = 0;                // straight part, before corners are rounded
  double speed = 0;                 // mm/s
  double corridor = 0;              // mm, for the reference point
  std::optional<PolarSpline> lead;  // an arc before it, from a different heading
  const Waypoint2d* waypoint = nullptr;
};

// Between a leg and the next.
struct Bend {
  double angle = 0;  // rad, to the right
  double least = 0;  // length of each leg that the minimum radius takes, mm
  i32 radius = 0;    // 0: none
};

tims::Error wrong(const Leg& leg, const std::string& what) {
  return {tims::Errc::kInvalidArgument, "waypoint " + std::to_string(leg.waypoint->id) + " at (" +
                                            std::to_string(leg.waypoint->x.raw()) + ", " +
                                            std::to_string(leg.waypoint->y.raw()) + "): " + what};
}

std::string mm(double value) { return std::to_string(std::lround(value)) + " mm"; }

double distance(const Point& at, const Point& from, const Point& to) {
  const double x = to.x - from.x;
  const double y = to.y - from.y;
  const double square = x * x + y * y;
  const double along = (at.x - from.x) * x + (at.y - from.y) * y;
  const double part = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
  return std::hypot(at.x - from.x - part * x, at.y - from.y - part * y);
}

class Maker {
 public:
  Maker(std::span<const Waypoint2d> waypoints, const PathLimits& limits)
      : waypoints_(waypoints), limits_(limits) {}

  tims::Result<std::vector<PolarSpline>> make(const double* start_heading);

 private:
  tims::Result<void> lay_legs(const double* start_heading);
  tims::Result<Leg> leg_to(const Waypoint2d& waypoint, const Point& from) const;
  void aim(Leg& leg) const;
  [[nodiscard]] std::optional<PolarSpline> lead_in(const Leg& leg, double heading,
                                                   double corridor) const;
  tims::Result<void> turn_into(Leg& leg, double heading, double corridor) const;
  tims::Result<void> find_bends();
  [[nodiscard]] double room(std::size_t leg, const Bend& bend, const Bend* other) const;
  [[nodiscard]] double radius_for(std::size_t i) const;  // of bend i
  tims::Result<void> choose_radius(std::size_t i);
  tims::Result<void> lay_splines();
  void add(PolarSpline spline, const Leg& leg, double speed);

  std::span<const Waypoint2d> waypoints_;
  const PathLimits& limits_;
  std::vector<Leg> legs_;
  std::vector<Bend> bends_;  // one less than legs
  std::vector<PolarSpline> splines_;
};

tims::Result<std::vector<PolarSpline>> Maker::make(const double* start_heading) {
  if (auto good = check(limits_); !good) return good.error();
  if (waypoints_.size() < 2)
    return tims::Error(tims::Errc::kInvalidArgument, "a path needs two waypoints or more");
  if (waypoints_.size() > kWaypointsMax)
    return tims::Error(tims::Errc::kTooBig, std::to_string(waypoints_.size()) + " waypoints, " +
                                                std::to_string(kWaypointsMax) + " are allowed");
  if (auto good = lay_legs(start_heading); !good) return good.error();
  if (auto good = find_bends(); !good) return good.error();
  if (auto good = lay_splines(); !good) return good.error();
  if (splines_.size() > kSplinesMax)
    return tims::Error(tims::Errc::kTooBig, "the path has " + std::to_string(splines_.size()) +
                                                " splines, " + std::to_string(kSplinesMax) +
                                                " fit into a message: use fewer waypoints");
  set_speeds(splines_);
  return std::move(splines_);
}

// --- legs

tims::Result<void> Maker::lay_legs(const double* start_heading) {
  Point at{static_cast<double>(waypoints_[0].x), static_cast<double>(waypoints_[0].y)};
  for (const Waypoint2d& waypoint : waypoints_.subspan(1)) {
    auto leg = leg_to(waypoint, at);
    if (!leg) return leg.error();
    if (leg->length < kSame) continue;
    const double* before = legs_.empty() ? start_heading : &legs_.back().heading;
    const bool turns = legs_.empty() || legs_.back().sense != leg->sense;
    if (turns && before != nullptr) {
      // There is no corridor at the start of the path.
      const double corridor = legs_.empty() ? kLongest : leg->corridor;
      if (auto good = turn_into(*leg, *before, corridor); !good) return good;
    }
    at = leg->to;
    legs_.push_back(*leg);
  }
  if (legs_.empty())
    return tims::Error(tims::Errc::kInvalidArgument, "all waypoints are at the same place");
  return {};
}

tims::Result<Leg> Maker::leg_to(const Waypoint2d& waypoint, const Point& from) const {
  Leg leg;
  leg.from = from;
  leg.to = {static_cast<double>(waypoint.x), static_cast<double>(waypoint.y)};
  leg.waypoint = &waypoint;
  leg.sense = waypoint.speed < 0 ? -1 : 1;
  const double target = std::abs(static_cast<double>(waypoint.speed));
  const double most = leg.sense < 0 ? limits_.backward_max : limits_.speed_max;
  leg.speed = target < kPathMakerDirectionOnly ? most : std::min(target, most);
  const double offset = waypoint.lbo > 0 ? static_cast<double>(waypoint.lbo) : limits_.corridor;
  leg.corridor = offset - limits_.half_width;
  aim(leg);
  if (leg.corridor <= 0)
    return wrong(leg,
                 "its corridor of " + mm(offset) + " to each side is narrower than the vehicle");
  if (leg.length > kLongest) return wrong(leg, "it is more than 1000 km from the previous one");
  return leg;
}

void Maker::aim(Leg& leg) const {
  const double x = leg.to.x - leg.from.x;
  const double y = leg.to.y - leg.from.y;
  leg.length = std::hypot(x, y);
  leg.heading = std::atan2(leg.sense * y, leg.sense * x);
}

// The heading of the vehicle is not that of the leg.
tims::Result<void> Maker::turn_into(Leg& leg, double heading, double corridor) const {
  if (std::abs(signed_angle(leg.heading - heading)) < kStraight || limits_.radius_min == 0)
    return {};
  leg.lead = lead_in(leg, heading, corridor);
  if (!leg.lead)
    return wrong(leg, "no arc leads to it within the corridor from the heading the vehicle has");
  const Pose end = pose_at(*leg.lead, leg.lead->length);
  leg.from = {end.x, end.y};
  aim(leg);
  return {};
}

// The maximum distance of an arc from the leg that follows it.
double strays(const PolarSpline& lead, const Leg& leg) {
  constexpr int kSteps = 32;
  double most = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const Pose at = pose_at(lead, lead.length * i / static_cast<double>(kSteps));
    most = std::max(most, distance({at.x, at.y}, leg.from, leg.to));
  }
  return most;
}

// An arc from the start of the leg with that heading, to the point where its tangent meets the
// waypoint.
std::optional<PolarSpline> Maker::lead_in(const Leg& leg, double heading, double corridor) const {
  std::optional<PolarSpline> best;
  const Pose start{.x = leg.from.x, .y = leg.from.y, .rho = heading};
  const Pose target = Pose{.x = leg.to.x, .y = leg.to.y} - start;
  const auto radius = std::ceil(std::max(limits_.radius_min, 1.0));
  for (const double side : {-1.0, 1.0}) {
    // In the frame of the arc's centre, mirrored to a right turn driven forward.
    const double x = leg.sense * target.x;
    const double y = radius - side * target.y;
    const double away = std::hypot(x, y);
    if (away <= radius) continue;
    const double angle = rack::heading(std::atan2(x, y) - std::acos(radius / away));
    const auto lead = arc(start, static_cast<i32>(side * radius), leg.sense * angle * radius);
    if (lead.length == 0 || (best && size(*best) <= size(lead))) continue;
    if (strays(lead, leg) <= corridor) best = lead;
  }
  return best;
}

// --- bends

tims::Result<void> Maker::find_bends() {
  bends_.resize(legs_.size() - 1);
  for (std::size_t i = 0; i < bends_.size(); ++i) {
    const Leg& next = legs_[i + 1];
    const double before = legs_[i].heading;
    if (legs_[i].sense != next.sense) continue;
    bends_[i].angle = signed_angle(next.heading - before);
    if (std::abs(bends_[i].angle) < kStraight) bends_[i].angle = 0;
    bends_[i].least = limits_.radius_min * std::tan(std::abs(bends_[i].angle) / 2);
  }
  for (std::size_t i = 0; i < bends_.size(); ++i)
    if (auto good = choose_radius(i); !good) return good;
  return {};
}

// The length of a leg that a bend may take; `other`: the bend at its other end.
double Maker::room(std::size_t leg, const Bend& bend, const Bend* other) const {
  const double length = legs_[leg].length;
  if (other == nullptr || other->angle == 0) return length;
  return bend.least + (length - bend.least - other->least) / 2;
}

// The largest radius that there is room for.
double Maker::radius_for(std::size_t i) const {
  const Bend& bend = bends_[i];
  const double half = std::abs(bend.angle) / 2;
  const Bend* before = i == 0 ? nullptr : &bends_[i - 1];
  const Bend* after = i + 1 == bends_.size() ? nullptr : &bends_[i + 1];
  const double along = std::min(room(i, bend, before), room(i + 1, bend, after));
  const double corridor = std::min(legs_[i].corridor, legs_[i + 1].corridor);
  const double cut = 1 / std::max(std::cos(half), 1e-9) - 1;
  return std::min({along / std::tan(half), corridor / std::max(cut, 1e-12), kRadiusMax});
}

tims::Result<void> Maker::choose_radius(std::size_t i) {
  Bend& bend = bends_[i];
  if (bend.angle == 0) return {};
  const Leg& leg = legs_[i];
  const double speed = std::min(leg.speed, legs_[i + 1].speed);
  const double ample =
      kAmple * std::max(speed / limits_.omega_max, speed * speed / limits_.lateral_acceleration);
  const double room = radius_for(i);
  double radius = std::min(room, std::max(ample, std::ceil(limits_.radius_min)));
  if (leg.waypoint->maxRadius > 0)
    radius = std::min(radius, static_cast<double>(leg.waypoint->maxRadius));
  radius = std::floor(radius);
  if (radius < limits_.radius_min)
    return wrong(leg, "the route turns by " + std::to_string(std::lround(degrees(bend.angle))) +
                          " degrees, with room for a radius of " + mm(std::max(0.0, radius)) +
                          "; the vehicle needs " + mm(limits_.radius_min));
  // In such a tight bend it is faster to stop and turn.
  if (limits_.radius_min == 0 && radius < kWorthwhile) return {};
  bend.radius = static_cast<i32>(std::copysign(radius, bend.angle * leg.sense));
  return {};
}

// --- splines

tims::Result<void> Maker::lay_splines() {
  splines_.reserve(2 * legs_.size() + 1);
  double taken = 0;  // length taken by the previous bend
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    const Leg& leg = legs_[i];
    if (leg.lead) add(*leg.lead, leg, leg.speed);
    const Bend bend = i < bends_.size() ? bends_[i] : Bend{};
    const double half = std::abs(bend.angle) / 2;
    const double takes = bend.radius == 0 ? 0 : std::abs(bend.radius) * std::tan(half);
    const double c = leg.sense * std::cos(leg.heading);
    const double s = leg.sense * std::sin(leg.heading);
    const auto at = [&](double along) {
      return Pose{.x = leg.from.x + along * c, .y = leg.from.y + along * s, .rho = leg.heading};
    };
    const double length = leg.length - taken - takes;
    if (length >= 1) add(line(at(taken), leg.sense * length), leg, leg.speed);
    if (bend.radius != 0) {
      const Leg& next = legs_[i + 1];
      const double turn = 2 * half * std::abs(bend.radius);
      if (turn >= 1)
        add(arc(at(leg.length - takes), bend.radius, leg.sense * turn), leg,
            std::min(leg.speed, next.speed));
    }
    taken = takes;
  }
  if (splines_.empty())
    return tims::Error(tims::Errc::kInvalidArgument, "the path is shorter than a millimetre");
  return {};
}

void Maker::add(PolarSpline spline, const Leg& leg, double speed) {
  spline.basepoint = *leg.waypoint;
  spline.type = leg.waypoint->type;
  spline.request = leg.waypoint->request;
  spline.lbo = whole_millimetres(leg.corridor + limits_.half_width);
  limit_speed(spline, limits_, speed);
  splines_.push_back(spline);
}

i32 whole(double value) {
  return static_cast<i32>(std::clamp(value, 0.0, 1.0 * std::numeric_limits<i32>::max()));
}

// The speed that can be reached at one end of a spline from the speed at the other.
double reached(double speed, double rate, const PolarSpline& spline) {
  return std::sqrt(speed * speed + 2 * rate * size(spline));
}

}  // namespace

tims::Result<void> check(const PathLimits& limits) {
  struct Limit {
    double value;
    bool may_be_zero;
    std::string_view name;
  };
  const std::array<Limit, 9> all = {{{limits.speed_max, false, "largest speed"},
                                     {limits.backward_max, false, "largest speed backward"},
                                     {limits.acceleration, false, "acceleration"},
                                     {limits.deceleration, false, "deceleration"},
                                     {limits.omega_max, false, "turning speed"},
                                     {limits.lateral_acceleration, false, "lateral acceleration"},
                                     {limits.radius_min, true, "smallest radius"},
                                     {limits.half_width, true, "half width of the vehicle"},
                                     {limits.corridor, true, "corridor"}}};
  for (const Limit& limit : all) {
    const bool good = limit.may_be_zero ? limit.value >= 0 : limit.value > 0;
    if (!good || limit.value > 1e9)
      return tims::Error(tims::Errc::kInvalidArgument,
                         "the " + std::string(limit.name) + " of a path must be more than 0");
  }
  return {};
}

tims::Result<std::vector<PolarSpline>> make_path(std::span<const Waypoint2d> waypoints,
                                                 const PathLimits& limits,
                                                 const double* start_heading) {
  return Maker(waypoints, limits).make(start_heading);
}

void limit_speed(PolarSpline& spline, const PathLimits& limits, double target) {
  double speed = std::min(target, spline.length < 0 ? limits.backward_max : limits.speed_max);
  if (spline.radius != 0) {
    const double radius = std::abs(static_cast<double>(spline.radius));
    speed = std::min(
        {speed, limits.omega_max * radius, std::sqrt(limits.lateral_acceleration * radius)});
  }
  spline.vMax = std::max(1, whole(speed));
  spline.accMax = std::max(1, whole(limits.acceleration));
  spline.decMax = std::max(1, whole(limits.deceleration));
}

void set_speeds(std::span<PolarSpline> splines, double start_speed) {
  double speed = start_speed;
  for (std::size_t i = 0; i < splines.size(); ++i) {
    PolarSpline& spline = splines[i];
    if (i > 0 && !runs_on(splines[i - 1], spline)) speed = 0;
    spline.vStart = whole(std::min<double>(speed, spline.vMax));
    speed = std::min<double>(spline.vMax, reached(spline.vStart, spline.accMax, spline));
    spline.vEnd = whole(speed);
  }
  speed = 0;
  for (std::size_t i = splines.size(); i-- > 0;) {
    PolarSpline& spline = splines[i];
    spline.vEnd = std::min(spline.vEnd.raw(), whole(speed));
    speed = std::min<double>(spline.vStart, reached(spline.vEnd, spline.decMax, spline));
    spline.vStart = whole(speed);
    if (i > 0 && !runs_on(splines[i - 1], spline)) speed = 0;
  }
}

}  // namespace rack::path
