#include "components/world/core/people.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "components/geometry/pose.h"
#include "components/world/core/noise.h"

namespace rack::world {

namespace {

constexpr double kPeopleSeconds = std::chrono::duration<double>(kStep).count();
constexpr double kStepsPerSecond = 1 / kPeopleSeconds;
constexpr std::uint64_t kLookEvery = 40;  // steps

// mm, mm/s, rad
constexpr double kLegRadius = 60;
constexpr double kHips = 0.5;  // share of the height
constexpr double kLegApart = 90;
constexpr double kStride = 220;  // of a leg before and behind the body, at normal speed
constexpr double kUsualSpeed = 1200;
constexpr double kGaitLength = 1400;  // length of two steps
constexpr double kTorso = 200;
constexpr double kAcceleration = 2500;
constexpr double kTurnRate = 4;
constexpr double kAhead = 400;  // distance of the point that it aims at
constexpr double kSlowsDown = 500;
constexpr double kRoomToRobot = 150;
constexpr double kStepsBack = 50;  // distance of a robot from which it steps back
constexpr double kRoomToOthers = 450;
constexpr double kShoulders = 400;               // distance at which people touch
constexpr double kForgets = 1500;                // a robot that was farther away is a new meeting
constexpr double kPlanned = kPersonRadius + 40;  // places count as reached within this
constexpr double kReached = 35;
constexpr double kLongestPause = 1e9;  // steps

}  // namespace

std::array<Circle, 2> legs(const Figure& person) {
  const double c = std::cos(person.rho);
  const double s = std::sin(person.rho);
  const double pace = std::min(1.2, std::hypot(person.vx, person.vy) / kUsualSpeed);
  const double swing = kStride * pace * std::sin(person.gait);
  const auto leg = [&](double ahead, double right) {
    return Circle{{person.at.x + ahead * c - right * s, person.at.y + ahead * s + right * c},
                  kLegRadius};
  };
  return {leg(swing, -kLegApart), leg(-swing, kLegApart)};
}

double meets(const Ray& ray, const Figure& person, double height) {
  constexpr double kFarthest = kStride * 1.2 + kLegApart + kLegRadius;
  const double x = person.at.x - ray.from.x;
  const double y = person.at.y - ray.from.y;
  if (std::abs(x * ray.y - y * ray.x) > kFarthest) return kNoHit;
  const double ahead = x * ray.x + y * ray.y;
  if (ahead < -kFarthest || ahead > ray.reach + kFarthest) return kNoHit;
  double nearest = kNoHit;
  for (const Circle& leg : legs(person))
    nearest = std::min(nearest, meets(ray, inside(ray, leg), kHips * height));
  const Inside torso = inside(ray, Circle{person.at, kTorso});
  if (torso.from > torso.to) return nearest;
  // From below, the ray hits at the height of the hips.
  const double enters = std::max(torso.from, 0.0);
  const double hips = kHips * height;
  if (ray.height_at(enters) >= hips) return std::min(nearest, meets(ray, torso, height));
  if (ray.climb <= 0) return nearest;
  const double rises = (hips - ray.height) / ray.climb;
  return rises <= torso.to ? std::min(nearest, rises) : nearest;
}

People::People(const PeopleDescription& description, const Area& area, const Surroundings& around,
               std::uint64_t seed)
    : description_(description) {
  if (description.count == 0 && description.walks.empty()) return;
  std::vector<MapPoint> wanted;
  for (const WalkDescription& walk : description.walks)
    wanted.insert(wanted.end(), walk.places.begin(), walk.places.end());
  roadmap_ = Roadmap(around.scenery, area, kPlanned, stirred(seed, 1), wanted);
  for (const WalkDescription& walk : description.walks)
    add_walker(walk, stirred(seed, 100 + figures_.size()));
  Random random(stirred(seed, 2));
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < roadmap_.size(); ++i) {
    const auto is_near = [&](const Box& robot) {
      return distance(roadmap_.place(i), robot) < 2 * kPersonRadius;
    };
    if (std::ranges::none_of(around.robots, is_near)) places.push_back(i);
  }
  const std::size_t all = figures_.size() + description.count;
  while (figures_.size() < all && !places.empty()) {
    const std::size_t index = random.below(static_cast<std::uint32_t>(places.size()));
    const std::size_t place = places[index];
    places.erase(places.begin() + static_cast<std::ptrdiff_t>(index));
    if (has_room(place)) add_stroller(place, stirred(seed, 100 + figures_.size()));
  }
  if (figures_.size() < all && !problem_)
    problem_ = fmt::format("there is room for {} people only, not for {}", figures_.size(), all);
}

void People::add_walker(const WalkDescription& walk, std::uint64_t seed) {
  std::vector<std::size_t> places;
  for (const MapPoint& at : walk.places) {
    const auto found = roadmap_.find(at);
    if (!found) {
      problem_ = fmt::format(
          "nobody can walk to x {:.0f} y {:.0f}: no room there, or no path to it", at.x, at.y);
      return;
    }
    places.push_back(*found);
  }
  if (places.empty() || !has_room(places.front())) {
    problem_ = "two walks begin at one place, or a walk has no places";
    return;
  }
  Behaviour behaviour = behaviour_at(places.front(), seed);
  behaviour.next = 1 % places.size();
  const double rest = std::chrono::duration<double>(walk.pause).count();
  behaviour.rest = steps_between(behaviour, rest, rest);
  behaviour.pause = behaviour.rest;
  behaviour.walk = std::move(places);
  behaviours_.push_back(std::move(behaviour));
  figures_.push_back({.at = walk.places.front()});
}

void People::add_stroller(std::size_t place, std::uint64_t seed) {
  Behaviour behaviour = behaviour_at(place, seed);
  behaviour.pause = steps_between(behaviour, 0, 2);
  figures_.push_back({.at = roadmap_.place(place),
                      .rho = static_cast<double>(behaviour.random.uniform(0, 6.28F))});
  behaviours_.push_back(std::move(behaviour));
}

People::Behaviour People::behaviour_at(std::size_t place, std::uint64_t seed) const {
  Behaviour behaviour(seed, stirred(seed, 1));
  behaviour.speed = description_.speed * static_cast<double>(behaviour.random.uniform(0.8F, 1.2F));
  behaviour.from = behaviour.to = behaviour.goal = place;
  return behaviour;
}

bool People::has_room(std::size_t place) const {
  return std::ranges::none_of(figures_, [&](const Figure& other) {
    return distance(other.at, roadmap_.place(place)) < 2 * kPersonRadius;
  });
}

int People::steps_between(Behaviour& behaviour, double from_s, double to_s) const {
  const double seconds = from_s + (to_s - from_s) * static_cast<double>(behaviour.random.uniform());
  return static_cast<int>(std::min(seconds * kStepsPerSecond, kLongestPause)) + 1;
}

int People::pause_at_goal(Behaviour& behaviour) const {
  if (!behaviour.walk.empty()) return behaviour.rest;
  return steps_between(behaviour, 0, std::chrono::duration<double>(description_.pause_max).count());
}

void People::choose_goal(Behaviour& behaviour) const {
  if (behaviour.walk.empty()) {
    behaviour.goal = behaviour.random.below(static_cast<std::uint32_t>(roadmap_.size()));
  } else {
    behaviour.goal = behaviour.walk[behaviour.next];
    behaviour.next = (behaviour.next + 1) % behaviour.walk.size();
  }
  behaviour.patience = steps_between(behaviour, 1, 4);
}

void People::turn_round(Behaviour& behaviour) {
  std::swap(behaviour.from, behaviour.to);
  choose_goal(behaviour);
}

People::Line People::line_of(std::size_t person) const {
  const Behaviour& behaviour = behaviours_[person];
  const MapPoint& to = roadmap_.place(behaviour.to);
  Line line{.from = roadmap_.place(behaviour.from)};
  line.length = distance(line.from, to);
  if (line.length > 0) {
    line.x = (to.x - line.from.x) / line.length;
    line.y = (to.y - line.from.y) / line.length;
    line.room = roadmap_.room(behaviour.from, behaviour.to) / 2;
  }
  const MapPoint& at = figures_[person].at;
  line.along = (at.x - line.from.x) * line.x + (at.y - line.from.y) * line.y;
  line.aside = (at.y - line.from.y) * line.x - (at.x - line.from.x) * line.y;
  return line;
}

void People::step(const Surroundings& around, std::span<Contacts> contacts) {
  ++steps_;
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    Behaviour& behaviour = behaviours_[i];
    if (steps_back(i, around, contacts)) continue;
    if (behaviour.pause > 0) {
      stop(i);
      if (--behaviour.pause == 0) choose_goal(behaviour);
      continue;
    }
    if (arrive(i) || (steps_ + i) % kLookEvery == 0) look_ahead(i, around);
    walk(i, around, contacts);
    turn_body(figures_[i]);
  }
}

void People::stand() {
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    stop(i);
    behaviours_[i].bumped.reset();
  }
}

// A braking robot still moves a little after a person has walked into it.
bool People::walked_against(const Box& robot) const {
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    const MapPoint& at = figures_[i].at;
    if (!overlap(robot, Circle{at, kBodyRadius})) continue;
    const Behaviour& behaviour = behaviours_[i];
    const Figure& person = figures_[i];
    const bool has_just =
        behaviour.bumped && static_cast<double>(steps_ - *behaviour.bumped) <= kStepsPerSecond;
    const double towards = person.vx * (robot.at.x - at.x) + person.vy * (robot.at.y - at.y);
    const bool is_about_to =
        behaviour.meeting == Meeting::kOverlooks && !behaviour.touches && towards > 0;
    if (!has_just && !is_about_to) return false;
  }
  return true;
}

void People::stop(std::size_t person) {
  figures_[person].vx = 0;
  figures_[person].vy = 0;
}

bool People::is_free(std::size_t person, double side, bool robots,
                     const Surroundings& around) const {
  const Line line = line_of(person);
  const MapPoint& at = figures_[person].at;
  for (const double ahead : {300.0, 600.0, 900.0}) {
    if (ahead > 300 && line.along + ahead > line.length) break;
    const MapPoint there = line.at(std::min(line.along + ahead, line.length), side * line.room);
    const auto blocked_by_person = [&](const Figure& other) {
      return &other != &figures_[person] && distance(there, other.at) < kRoomToOthers &&
             distance(there, other.at) < distance(at, other.at);
    };
    const double room = behaviours_[person].squeezes ? kRoomToRobot / 2 : kRoomToRobot;
    const auto blocked_by_robot = [&](const Box& box) {
      return distance(there, box) < kPersonRadius + room &&
             distance(there, box) < distance(at, box);
    };
    const auto blocked_by_obstacle = [&](const Solid& solid) {
      return distance(there, solid) < kPersonRadius + kRoomToRobot / 2;
    };
    if (std::ranges::any_of(figures_, blocked_by_person) ||
        (robots && std::ranges::any_of(around.robots, blocked_by_robot)) ||
        std::ranges::any_of(around.obstacles, blocked_by_obstacle))
      return false;
  }
  return true;
}

void People::look_ahead(std::size_t person, const Surroundings& around) {
  Behaviour& behaviour = behaviours_[person];
  const MapPoint& at = figures_[person].at;
  const auto is_near = [&](const Box& box) { return distance(at, box) < kForgets; };
  if (std::ranges::none_of(around.robots, is_near)) {
    behaviour.meeting = Meeting::kNone;
    behaviour.touches = behaviour.squeezes = false;
  } else if (behaviour.meeting == Meeting::kNone) {
    const bool avoids = static_cast<double>(behaviour.luck.uniform()) < description_.avoids_share;
    behaviour.meeting = avoids ? Meeting::kAvoids : Meeting::kOverlooks;
  }
  // A person who has walked into a robot has noticed it.
  const bool robots = behaviour.touches || behaviour.meeting != Meeting::kOverlooks;
  behaviour.waits = true;
  for (const double side : {1.0, 0.0, -1.0}) {
    if (!is_free(person, side, robots, around)) continue;
    behaviour.side = side;
    behaviour.waits = false;
    break;
  }
  if (!std::exchange(behaviour.is_stopped, false) && !behaviour.waits) return;
  behaviour.patience -= static_cast<int>(kLookEvery);
  if (behaviour.patience > 0) return;
  behaviour.squeezes = true;
  if (!std::exchange(behaviour.has_turned, true) || !leave_line(person, around))
    turn_round(behaviour);
}

// A person who was pushed off its line by a robot may be blocked in both directions of the line.
bool People::leave_line(std::size_t person, const Surroundings& around) {
  constexpr double kFarthest = 4000;
  const MapPoint& at = figures_[person].at;
  std::optional<std::size_t> nearest;
  double left = kFarthest;
  for (std::size_t i = 0; i < roadmap_.size(); ++i) {
    const double away = distance(at, roadmap_.place(i));
    if (away > kPlanned && away < left && can_walk(at, roadmap_.place(i), around)) {
      nearest = i;
      left = away;
    }
  }
  if (!nearest) return false;
  Behaviour& behaviour = behaviours_[person];
  behaviour.from = behaviour.to = *nearest;
  behaviour.goes_to_line = true;  // straight to that place
  choose_goal(behaviour);
  return true;
}

// Straight, without walls, and at no point nearer to a robot or person that it may not touch.
bool People::can_walk(const MapPoint& from, const MapPoint& to, const Surroundings& around) const {
  constexpr double kStepLength = 50;
  const double length = distance(from, to);
  const auto is_in_the_way = [&](const MapPoint& there, const auto& what, double reach) {
    const double left = distance(there, what);
    return left < reach && left < distance(from, what);
  };
  for (double along = kStepLength; along < length + kStepLength; along += kStepLength) {
    const double share = std::min(1.0, along / length);
    const MapPoint there{from.x + (to.x - from.x) * share, from.y + (to.y - from.y) * share};
    if (around.scenery.clearance(there, kPersonRadius) < kPersonRadius) return false;
    for (const Box& robot : around.robots)
      if (is_in_the_way(there, robot, kPersonRadius + kRoomToRobot)) return false;
    for (const Solid& solid : around.obstacles)
      if (is_in_the_way(there, solid, kPersonRadius + kRoomToRobot / 2)) return false;
    for (const Figure& other : figures_)
      if (is_in_the_way(there, other.at, kRoomToOthers)) return false;
  }
  return true;
}

// Moves away from the nearest point of a robot, if there is room; who has overlooked it, when he
// touches it.
bool People::steps_back(std::size_t person, const Surroundings& around,
                        std::span<Contacts> contacts) {
  Figure& figure = figures_[person];
  const Behaviour& behaviour = behaviours_[person];
  if (behaviour.meeting == Meeting::kOverlooks && !behaviour.touches) return false;
  const auto too_near = std::ranges::find_if(around.robots, [&](const Box& box) {
    return distance(figure.at, box) < kPersonRadius + kStepsBack;
  });
  if (too_near == around.robots.end()) return false;
  constexpr double kAside = 1;
  const auto slope = [&](double x, double y) {
    return distance({figure.at.x + x, figure.at.y + y}, *too_near) -
           distance({figure.at.x - x, figure.at.y - y}, *too_near);
  };
  const double x = slope(kAside, 0);
  const double y = slope(0, kAside);
  const double length = std::hypot(x, y);
  if (length == 0) return false;
  const double step = kUsualSpeed * kPeopleSeconds / length;
  const MapPoint to{figure.at.x + x * step, figure.at.y + y * step};
  const bool has_room = around.scenery.clearance(to, kPersonRadius) >= kPersonRadius;
  if (!has_room || meets_somebody(person, to, around, contacts)) return false;
  figure.at = to;
  stop(person);
  return true;
}

// At a place, starts the next line or a pause; returns whether it pauses.
bool People::arrive(std::size_t person) {
  Behaviour& behaviour = behaviours_[person];
  if (behaviour.goes_to_line) return false;
  const double left = distance(figures_[person].at, roadmap_.place(behaviour.to));
  const std::size_t next = roadmap_.next(behaviour.to, behaviour.goal);
  double reached = kReached;
  if (behaviour.to != behaviour.goal)
    reached +=
        std::min(roadmap_.room(behaviour.from, behaviour.to), roadmap_.room(behaviour.to, next)) /
        2;
  if (left > reached) return false;
  if (behaviour.to == behaviour.goal) {
    behaviour.from = behaviour.to;
    stop(person);
    behaviour.pause = pause_at_goal(behaviour);
  } else {
    behaviour.from = behaviour.to;
    behaviour.to = next;
  }
  behaviour.has_turned = false;
  return true;
}

// The target velocity.
MapPoint People::target_velocity(std::size_t person) const {
  const Behaviour& behaviour = behaviours_[person];
  const MapPoint& at = figures_[person].at;
  const Line line = line_of(person);
  if (behaviour.waits || behaviour.pause > 0) return {};
  const double aim_along = std::min(line.along + kAhead, line.length);
  const double fades = std::clamp((line.length - aim_along) / kAhead, 0.0, 1.0);
  const MapPoint aim = behaviour.goes_to_line
                           ? line.at(std::clamp(line.along, 0.0, line.length), 0)
                           : line.at(aim_along, behaviour.side * line.room * fades);
  const double left = distance(at, aim);
  if (left == 0) return {};
  const double to_place = distance(at, roadmap_.place(behaviour.to));
  const bool is_narrow =
      behaviour.to == behaviour.goal || line.room < 100 || behaviour.goes_to_line;
  const double slower = is_narrow ? std::clamp(to_place / kSlowsDown, 0.15, 1.0) : 1.0;
  const double speed = std::min(behaviour.speed * slower, left * kStepsPerSecond);
  return {(aim.x - at.x) / left * speed, (aim.y - at.y) / left * speed};
}

void People::walk(std::size_t person, const Surroundings& around, std::span<Contacts> contacts) {
  Figure& figure = figures_[person];
  Behaviour& behaviour = behaviours_[person];
  const MapPoint wanted = target_velocity(person);
  const double x = wanted.x - figure.vx;
  const double y = wanted.y - figure.vy;
  const double change = std::hypot(x, y);
  const double share =
      behaviour.goes_to_line ? 1 : std::min(1.0, kAcceleration * kPeopleSeconds / change);
  if (change > 0) {
    figure.vx += x * share;
    figure.vy += y * share;
  }
  const MapPoint to{figure.at.x + figure.vx * kPeopleSeconds,
                    figure.at.y + figure.vy * kPeopleSeconds};
  if (!may_go(person, to, around, contacts)) return stop(person);
  figure.gait += std::hypot(figure.vx, figure.vy) * kPeopleSeconds / kGaitLength * 2 * kPi;
  figure.at = to;
  constexpr double kOnLine = 10;
  if (behaviour.goes_to_line && std::abs(line_of(person).aside) < kOnLine)
    behaviour.goes_to_line = false;
}

bool People::may_go(std::size_t person, const MapPoint& to, const Surroundings& around,
                    std::span<Contacts> contacts) {
  Behaviour& behaviour = behaviours_[person];
  if (around.scenery.clearance(to, kPersonRadius) < kPersonRadius) {
    behaviour.goes_to_line = true;
    return false;
  }
  behaviour.is_stopped = behaviour.is_stopped || meets_somebody(person, to, around, contacts);
  return !behaviour.is_stopped;
}

// Whether it would touch a robot or person that it does not touch yet, or overlap more.
bool People::meets_somebody(std::size_t person, const MapPoint& to, const Surroundings& around,
                            std::span<Contacts> contacts) {
  const MapPoint& at = figures_[person].at;
  const auto is_nearer = [&](double reach, const auto& what) {
    const double left = distance(to, what);
    return left < reach && left < distance(at, what);
  };
  for (const Solid& solid : around.obstacles)
    if (is_nearer(kPersonRadius, solid)) return true;
  for (const Figure& other : figures_)
    if (&other != &figures_[person] && is_nearer(kShoulders, other.at)) return true;
  Behaviour& behaviour = behaviours_[person];
  const bool sees = behaviour.touches || behaviour.meeting == Meeting::kAvoids;
  for (std::size_t i = 0; i < around.robots.size(); ++i) {
    if (!is_nearer(kPersonRadius + (sees ? kRoomToRobot / 2 : 0), around.robots[i])) continue;
    if (!sees) {
      ++contacts[i].bumped;
      behaviour.bumped = steps_;
    }
    behaviour.touches = true;
    return true;
  }
  return false;
}

void People::turn_body(Figure& figure) {
  constexpr double kWalks = 100;
  if (std::hypot(figure.vx, figure.vy) < kWalks) return;
  const double turn = signed_angle(std::atan2(figure.vy, figure.vx) - figure.rho);
  figure.rho = heading(figure.rho +
                       std::clamp(turn, -kTurnRate * kPeopleSeconds, kTurnRate * kPeopleSeconds));
}

}  // namespace rack::world
