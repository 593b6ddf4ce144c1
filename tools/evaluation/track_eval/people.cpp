#include "tools/evaluation/track_eval/people.h"

#include <algorithm>
#include <cmath>

namespace rack::track_eval {
namespace {

constexpr double kLength = 16000;  // mm to the east
constexpr double kDepth = 12000;   // mm to the north
constexpr double kLegRadius = 60;
constexpr double kLegsApart = 90;       // mm from the centre
constexpr double kSwing = 220;          // mm, amplitude of a leg at fast walking
constexpr double kStep = 700;           // mm
constexpr double kAcceleration = 1200;  // mm/s^2
constexpr double kFromWalls = 500;
constexpr double kApart = 700;  // mm between two people
constexpr double kFromRobot = 900;
constexpr double kPatience = 1;  // s
constexpr double kRestMost = 3;  // s
constexpr double kSlice = 0.02;  // s
constexpr std::size_t kNobody = ~std::size_t{0};
constexpr double kOdometryScale = 1.01;
constexpr double kOdometryDrift = radians(0.5);  // per m
constexpr double kKnownTo = 20;                  // mm, position noise of a localised robot
constexpr double kKnownToTurn = radians(0.3);

void add_box(DxfDrawing& drawing, double x, double y, double x2, double y2) {
  drawing.lines.push_back({{x, y}, {x2, y}});
  drawing.lines.push_back({{x2, y}, {x2, y2}});
  drawing.lines.push_back({{x2, y2}, {x, y2}});
  drawing.lines.push_back({{x, y2}, {x, y}});
}

}  // namespace

DxfDrawing Hall::plan() {
  DxfDrawing drawing;
  add_box(drawing, 0, 0, kLength / 1000, kDepth / 1000);
  add_box(drawing, 4, 3, 4.4, 3.4);
  add_box(drawing, 12, 3, 12.4, 3.4);
  add_box(drawing, 4, 9, 4.4, 9.4);
  add_box(drawing, 12, 9, 12.4, 9.4);
  add_box(drawing, 7.5, 0.5, 9.5, 1.3);
  return drawing;
}

Hall::Hall(const HallSettings& settings)
    : settings_(settings),
      walls_(plan(), 1000, 0, 0),
      random_(settings.seed),
      people_(settings.people),
      walks_(settings.people),
      ranges_(settings.beams),
      met_(settings.beams) {
  move_robot(0);
  odometry_ = robot_;
  for (std::size_t i = 0; i < people_.size(); ++i) {
    do people_[i].at = somewhere();
    while (meets(i, people_[i].at));
    choose_goal(walks_[i], people_[i].at);
  }
  place_legs();
}

MapPoint Hall::somewhere() {
  for (;;) {
    const MapPoint at{static_cast<double>(random_.uniform()) * kDepth,
                      static_cast<double>(random_.uniform()) * kLength};
    if (walls_.clearance(at) > kFromWalls) return at;
  }
}

bool Hall::is_free(const MapPoint& from, const MapPoint& to) const {
  constexpr int kParts = 60;
  for (int i = 0; i <= kParts; ++i) {
    const double part = static_cast<double>(i) / kParts;
    if (walls_.clearance({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)}) <
        kFromWalls - 1)
      return false;
  }
  return true;
}

void Hall::choose_goal(Walk& walk, const MapPoint& from) {
  do walk.goal = somewhere();
  while (distance(walk.goal, from) < 2 * kApart || !is_free(from, walk.goal));
  walk.direction = std::atan2(walk.goal.y - from.y, walk.goal.x - from.x);
  walk.wanted = static_cast<double>(random_.uniform(600, 1600));
  walk.speed = 0;
  walk.waits = 0;
}

bool Hall::meets(std::size_t i, const MapPoint& next) const {
  // Moving away from a near person is permitted.
  const auto nearer = [&](const MapPoint& other, double least) {
    return distance(next, other) < least && distance(next, other) <= distance(people_[i].at, other);
  };
  if (nearer({robot_.x, robot_.y}, kFromRobot)) return true;
  for (std::size_t j = 0; j < people_.size(); ++j)
    if (j != i && nearer(people_[j].at, kApart)) return true;
  return false;
}

void Hall::move_person(std::size_t i, double seconds) {
  Walk& walk = walks_[i];
  Person& person = people_[i];
  person.velocity = {};
  if (walk.rest > 0) {
    walk.rest -= seconds;
    return;
  }
  const double left = distance(walk.goal, person.at);
  const double stops = std::sqrt(2 * kAcceleration * std::max(left - 10, 0.0));
  walk.speed = std::min({walk.speed + kAcceleration * seconds, walk.wanted, stops});
  const MapPoint v{walk.speed * std::cos(walk.direction), walk.speed * std::sin(walk.direction)};
  const MapPoint next{person.at.x + v.x * seconds, person.at.y + v.y * seconds};
  if (left < 20 || walk.waits > kPatience) {
    walk.rest = static_cast<double>(random_.uniform()) * kRestMost;
    choose_goal(walk, person.at);
    return;
  }
  if (meets(i, next)) {
    walk.speed = 0;
    walk.waits += seconds;
    return;
  }
  person.at = next;
  person.velocity = v;
  walk.phase += kPi * walk.speed * seconds / kStep;
}

void Hall::move_robot(double seconds) {
  const Pose before = robot_;
  travelled_ += settings_.robot_speed * seconds;
  constexpr double kNorth = 2000;
  constexpr double kEast = 3500;
  const double part = travelled_ / 2800;
  robot_ = {.x = kDepth / 2 + kNorth * std::sin(part),
            .y = kLength / 2 - kEast * std::cos(part),
            .rho = heading(std::atan2(kEast * std::sin(part), kNorth * std::cos(part)))};
  if (seconds == 0) return;
  Pose step = robot_ - before;
  step.rho += kOdometryDrift * std::hypot(step.x, step.y) / 1000;
  step.x *= kOdometryScale;
  step.y *= kOdometryScale;
  odometry_ = odometry_ + step;
  if (!settings_.localised) return;
  odometry_ = robot_;
  odometry_.x += kKnownTo * static_cast<double>(random_.normal());
  odometry_.y += kKnownTo * static_cast<double>(random_.normal());
  odometry_.rho = heading(odometry_.rho + kKnownToTurn * static_cast<double>(random_.normal()));
}

void Hall::step() {
  const auto slices = static_cast<int>(std::lround(settings_.period / kSlice));
  const double slice = settings_.period / std::max(slices, 1);
  for (int n = 0; n < std::max(slices, 1); ++n)
    for (std::size_t i = 0; i < people_.size(); ++i) move_person(i, slice);
  move_robot(settings_.period);
  now_ += settings_.period;
  place_legs();
}

void Hall::place_legs() {
  legs_.clear();
  for (std::size_t i = 0; i < people_.size(); ++i) {
    const Walk& walk = walks_[i];
    const double c = std::cos(walk.direction);
    const double s = std::sin(walk.direction);
    const double swing = kSwing * std::min(walk.speed / 1200, 1.0) * std::sin(walk.phase);
    for (const double side : {-1.0, 1.0}) {
      const double ahead = side * swing;
      const double across = side * kLegsApart;
      legs_.push_back({.at = {people_[i].at.x + ahead * c - across * s,
                              people_[i].at.y + ahead * s + across * c},
                       .person = i});
    }
  }
}

void Hall::cast_legs(double first, double step) {
  for (const Leg& leg : legs_) {
    const double dx = leg.at.x - robot_.x;
    const double dy = leg.at.y - robot_.y;
    const double away = std::hypot(dx, dy);
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      const double angle = first + step * static_cast<double>(i);
      const double along = dx * std::cos(angle) + dy * std::sin(angle);
      const double beside = away * away - along * along;
      if (along <= 0 || beside >= kLegRadius * kLegRadius) continue;
      const double range = along - std::sqrt(kLegRadius * kLegRadius - beside);
      if (range >= ranges_[i]) continue;
      ranges_[i] = range;
      met_[i] = leg.person;
    }
  }
}

void Hall::scan(Scan2dData& scan) {
  const double opening = radians(settings_.opening);
  const double step = opening / static_cast<double>(std::max(settings_.beams, 2U) - 1);
  const double first = robot_.rho - opening / 2;
  walls_.cast({.from = {robot_.x, robot_.y}, .first = first, .step = step}, settings_.range_max,
              ranges_);
  std::ranges::fill(met_, kNobody);
  for (Person& person : people_) person.beams = 0;
  cast_legs(first, step);
  scan = {.recordingTime = static_cast<std::uint32_t>(std::lround(now_ * 1000)),
          .maxRange = whole_millimetres(settings_.range_max)};
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const bool lost = static_cast<double>(random_.uniform()) < settings_.dropped;
    const bool nothing = lost || ranges_[i] >= settings_.range_max;
    const double measured = ranges_[i] + settings_.noise * static_cast<double>(random_.normal());
    const double range = nothing ? settings_.range_max : measured;
    if (!nothing && met_[i] != kNobody) ++people_[met_[i]].beams;
    const double angle = -opening / 2 + step * static_cast<double>(i);
    scan.points.push_back({.x = whole_millimetres(range * std::cos(angle)),
                           .y = whole_millimetres(range * std::sin(angle)),
                           .z = whole_millimetres(range),
                           .type = nothing ? scan_point::kInvalid | scan_point::kMaxRange : 0});
  }
}

PositionData Hall::position() const {
  return {.recordingTime = static_cast<std::uint32_t>(std::lround(now_ * 1000)),
          .pos = odometry_.position()};
}

}  // namespace rack::track_eval
