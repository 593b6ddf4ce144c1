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
constexpr double kHips = 0.5;  // of the height
constexpr double kLegApart = 90;
constexpr double kStride = 220;  // of a leg before and behind the body, at a usual pace
constexpr double kUsualSpeed = 1200;
constexpr double kGaitLength = 1400;  // of both steps
constexpr double kTorso = 200;
constexpr double kAcceleration = 2500;
constexpr double kTurnRate = 4;
constexpr double kAhead = 400;  // how far ahead it aims
constexpr double kSlowsDown = 500;
constexpr double kRoomToRobot = 150;
constexpr double kStepsBack = 50;  // from a robot that is as near
constexpr double kRoomToOthers = 450;
constexpr double kShoulders = 400;               // people touch
constexpr double kForgets = 1500;                // a robot that is as far is met anew
constexpr double kPlanned = kPersonRadius + 40;  // places are reached nearly
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
  // From below it is met where the ray comes to the height of the hips.
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
      problem_ =
          fmt::format("nobody can walk to x {:.0f} y {:.0f}: no room there, or no way", at.x, at.y);
      return;
    }
    places.push_back(*found);
  }
  if (places.empty() || !has_room(places.front())) {
    problem_ = "two walks begin at one place, or one has no place";
    return;
  }
  Mind mind = mind_at(places.front(), seed);
  mind.next = 1 % places.size();
  const double rest = std::chrono::duration<double>(walk.pause).count();
  mind.rest = steps_between(mind, rest, rest);
  mind.pause = mind.rest;
  mind.walk = std::move(places);
  minds_.push_back(std::move(mind));
  figures_.push_back({.at = walk.places.front()});
}

void People::add_stroller(std::size_t place, std::uint64_t seed) {
  Mind mind = mind_at(place, seed);
  mind.pause = steps_between(mind, 0, 2);
  figures_.push_back(
      {.at = roadmap_.place(place), .rho = static_cast<double>(mind.random.uniform(0, 6.28F))});
  minds_.push_back(std::move(mind));
}

People::Mind People::mind_at(std::size_t place, std::uint64_t seed) const {
  Mind mind(seed, stirred(seed, 1));
  mind.speed = description_.speed * static_cast<double>(mind.random.uniform(0.8F, 1.2F));
  mind.from = mind.to = mind.goal = place;
  return mind;
}

bool People::has_room(std::size_t place) const {
  return std::ranges::none_of(figures_, [&](const Figure& other) {
    return distance(other.at, roadmap_.place(place)) < 2 * kPersonRadius;
  });
}

int People::steps_between(Mind& mind, double from_s, double to_s) const {
  const double seconds = from_s + (to_s - from_s) * static_cast<double>(mind.random.uniform());
  return static_cast<int>(std::min(seconds * kStepsPerSecond, kLongestPause)) + 1;
}

int People::pause_at_goal(Mind& mind) const {
  if (!mind.walk.empty()) return mind.rest;
  return steps_between(mind, 0, std::chrono::duration<double>(description_.pause_max).count());
}

void People::choose_goal(Mind& mind) const {
  if (mind.walk.empty()) {
    mind.goal = mind.random.below(static_cast<std::uint32_t>(roadmap_.size()));
  } else {
    mind.goal = mind.walk[mind.next];
    mind.next = (mind.next + 1) % mind.walk.size();
  }
  mind.patience = steps_between(mind, 1, 4);
}

void People::turn_round(Mind& mind) {
  std::swap(mind.from, mind.to);
  choose_goal(mind);
}

People::Line People::line_of(std::size_t person) const {
  const Mind& mind = minds_[person];
  const MapPoint& to = roadmap_.place(mind.to);
  Line line{.from = roadmap_.place(mind.from)};
  line.length = distance(line.from, to);
  if (line.length > 0) {
    line.x = (to.x - line.from.x) / line.length;
    line.y = (to.y - line.from.y) / line.length;
    line.room = roadmap_.room(mind.from, mind.to) / 2;
  }
  const MapPoint& at = figures_[person].at;
  line.along = (at.x - line.from.x) * line.x + (at.y - line.from.y) * line.y;
  line.aside = (at.y - line.from.y) * line.x - (at.x - line.from.x) * line.y;
  return line;
}

void People::step(const Surroundings& around, std::span<Contacts> contacts) {
  ++steps_;
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    Mind& mind = minds_[i];
    if (steps_back(i, around, contacts)) continue;
    if (mind.pause > 0) {
      stop(i);
      if (--mind.pause == 0) choose_goal(mind);
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
    minds_[i].bumped.reset();
  }
}

// A robot that brakes still moves a little when somebody has walked against it.
bool People::walked_against(const Box& robot) const {
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    const MapPoint& at = figures_[i].at;
    if (!overlap(robot, Circle{at, kPersonRadius})) continue;
    const Mind& mind = minds_[i];
    const Figure& person = figures_[i];
    const bool has_just =
        mind.bumped && static_cast<double>(steps_ - *mind.bumped) <= kStepsPerSecond;
    const double towards = person.vx * (robot.at.x - at.x) + person.vy * (robot.at.y - at.y);
    const bool is_about_to = mind.meeting == Meeting::kOverlooks && !mind.touches && towards > 0;
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
    const auto person_in_way = [&](const Figure& other) {
      return &other != &figures_[person] && distance(there, other.at) < kRoomToOthers &&
             distance(there, other.at) < distance(at, other.at);
    };
    const double room = minds_[person].squeezes ? kRoomToRobot / 2 : kRoomToRobot;
    const auto robot_in_way = [&](const Box& box) {
      return distance(there, box) < kPersonRadius + room &&
             distance(there, box) < distance(at, box);
    };
    const auto obstacle_in_way = [&](const Solid& solid) {
      return distance(there, solid) < kPersonRadius + kRoomToRobot / 2;
    };
    if (std::ranges::any_of(figures_, person_in_way) ||
        (robots && std::ranges::any_of(around.robots, robot_in_way)) ||
        std::ranges::any_of(around.obstacles, obstacle_in_way))
      return false;
  }
  return true;
}

void People::look_ahead(std::size_t person, const Surroundings& around) {
  Mind& mind = minds_[person];
  const MapPoint& at = figures_[person].at;
  const auto is_near = [&](const Box& box) { return distance(at, box) < kForgets; };
  if (std::ranges::none_of(around.robots, is_near)) {
    mind.meeting = Meeting::kNone;
    mind.touches = mind.squeezes = false;
  } else if (mind.meeting == Meeting::kNone) {
    const bool avoids = static_cast<double>(mind.luck.uniform()) < description_.avoids_share;
    mind.meeting = avoids ? Meeting::kAvoids : Meeting::kOverlooks;
  }
  // Who has walked against a robot has seen it now.
  const bool robots = mind.touches || mind.meeting != Meeting::kOverlooks;
  mind.waits = true;
  for (const double side : {1.0, 0.0, -1.0}) {
    if (!is_free(person, side, robots, around)) continue;
    mind.side = side;
    mind.waits = false;
    break;
  }
  if (!std::exchange(mind.is_stopped, false) && !mind.waits) return;
  mind.patience -= static_cast<int>(kLookEvery);
  if (mind.patience > 0) return;
  mind.squeezes = true;
  turn_round(mind);
}

// Away from the nearest point of a robot, if there is room.
bool People::steps_back(std::size_t person, const Surroundings& around,
                        std::span<Contacts> contacts) {
  Figure& figure = figures_[person];
  if (minds_[person].meeting == Meeting::kOverlooks) return false;
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

// At a place, the next way begins, or a pause: then true.
bool People::arrive(std::size_t person) {
  Mind& mind = minds_[person];
  if (mind.goes_to_line) return false;
  const double left = distance(figures_[person].at, roadmap_.place(mind.to));
  const std::size_t next = roadmap_.next(mind.to, mind.goal);
  double reached = kReached;
  if (mind.to != mind.goal)
    reached += std::min(roadmap_.room(mind.from, mind.to), roadmap_.room(mind.to, next)) / 2;
  if (left > reached) return false;
  if (mind.to == mind.goal) {
    mind.from = mind.to;
    stop(person);
    mind.pause = pause_at_goal(mind);
  } else {
    mind.from = mind.to;
    mind.to = next;
  }
  return true;
}

// The velocity it would like to have.
MapPoint People::wish(std::size_t person) const {
  const Mind& mind = minds_[person];
  const MapPoint& at = figures_[person].at;
  const Line line = line_of(person);
  if (mind.waits || mind.pause > 0) return {};
  const double way = std::min(line.along + kAhead, line.length);
  const double fades = std::clamp((line.length - way) / kAhead, 0.0, 1.0);
  const MapPoint aim = mind.goes_to_line ? line.at(std::clamp(line.along, 0.0, line.length), 0)
                                         : line.at(way, mind.side * line.room * fades);
  const double left = distance(at, aim);
  if (left == 0) return {};
  const double to_place = distance(at, roadmap_.place(mind.to));
  const bool is_narrow = mind.to == mind.goal || line.room < 100 || mind.goes_to_line;
  const double slower = is_narrow ? std::clamp(to_place / kSlowsDown, 0.15, 1.0) : 1.0;
  const double speed = std::min(mind.speed * slower, left * kStepsPerSecond);
  return {(aim.x - at.x) / left * speed, (aim.y - at.y) / left * speed};
}

void People::walk(std::size_t person, const Surroundings& around, std::span<Contacts> contacts) {
  Figure& figure = figures_[person];
  Mind& mind = minds_[person];
  const MapPoint wanted = wish(person);
  const double x = wanted.x - figure.vx;
  const double y = wanted.y - figure.vy;
  const double change = std::hypot(x, y);
  const double share =
      mind.goes_to_line ? 1 : std::min(1.0, kAcceleration * kPeopleSeconds / change);
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
  if (mind.goes_to_line && std::abs(line_of(person).aside) < kOnLine) mind.goes_to_line = false;
}

bool People::may_go(std::size_t person, const MapPoint& to, const Surroundings& around,
                    std::span<Contacts> contacts) {
  Mind& mind = minds_[person];
  if (around.scenery.clearance(to, kPersonRadius) < kPersonRadius) {
    mind.goes_to_line = true;
    return false;
  }
  mind.is_stopped = mind.is_stopped || meets_somebody(person, to, around, contacts);
  return !mind.is_stopped;
}

// Whether it would touch what it does not touch yet, or touch it more.
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
  Mind& mind = minds_[person];
  const bool sees = mind.touches || mind.meeting == Meeting::kAvoids;
  for (std::size_t i = 0; i < around.robots.size(); ++i) {
    if (!is_nearer(kPersonRadius + (sees ? kRoomToRobot / 2 : 0), around.robots[i])) continue;
    if (!sees) {
      ++contacts[i].bumped;
      mind.bumped = steps_;
    }
    mind.touches = true;
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
