#include "components/world/core/state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "components/world/core/noise.h"

namespace rack::world {

namespace {

constexpr double kStateSeconds = std::chrono::duration<double>(kStep).count();
constexpr std::uint64_t kFreeAfter =
    100;  // steps without contact; then the next touch is a new contact
constexpr std::size_t kPutKept = 2 * kPutMax;
constexpr double kPutLargest = 100e3;  // mm

std::string_view what(Met met) {
  switch (met) {
    case Met::kWall:
      return "a wall or the end of the ground";
    case Met::kObstacle:
      return "an obstacle";
    case Met::kPerson:
      return "a person";
    case Met::kRobot:
      return "another robot";
    default:
      return "nothing";
  }
}

}  // namespace

World::State::Robot::Robot(const RobotDescription& of, std::uint64_t seed)
    : vehicle(of, stirred(seed, 0)) {
  for (std::size_t i = 0; i < of.sensors.size(); ++i)
    sensors.emplace_back(of.sensors[i], stirred(seed, i + 1));
  now = {.at = {of.start.x, of.start.y}, .rho = of.start.rho};
  free_steps = kFreeAfter;
}

World::State::State(WorldDescription description, tims::Time begin)
    : description_(std::move(description)),
      begin_(begin),
      now_(begin),
      scenery_(description_.walls, description_.obstacles),
      history_(0, 0, 0, begin) {
  const std::uint64_t seed = description_.seed;
  for (std::size_t i = 0; i < description_.robots.size(); ++i) {
    const RobotDescription& robot = description_.robots[i];
    robots_.emplace_back(robot, stirred(seed, 1000 + i));
    hulls_.push_back(hull(i, {robot.start.x, robot.start.y}, robot.start.rho));
    for (Sensor& sensor : robots_[i].sensors) {
      if (sensor.is.axis.about == TurnedAbout::kNothing) continue;
      sensor.axis = axes_.size();
      axes_.emplace_back();
    }
  }
  people_ = People(description_.people, description_.people.area.value_or(description_.ground),
                   surroundings(), stirred(seed, 1));
  history_ = History(robots_.size(), people_.size(), axes_.size(), begin);
  contacts_.resize(robots_.size());
  for (std::size_t i = 0; i < robots_.size(); ++i) history_.robot(i) = robots_[i].now;
  for (std::size_t i = 0; i < people_.size(); ++i) history_.person(i) = people_.figures()[i];
  put_.reserve(kPutKept);
  solids_.reserve(kPutMax);
  const navigation::Geodetic origin{description_.origin.latitude, description_.origin.longitude, 0};
  grid_ = utm_grid(origin);
  grid_origin_ = project(origin, grid_);
}

std::optional<std::string> World::State::problem() const {
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (const Met met = collision(i, hulls_[i]); met != Met::kNothing)
      return fmt::format("robot {} starts in {}", description_.robots[i].name, what(met));
  return people_.problem();
}

Box World::State::hull(std::size_t robot, const MapPoint& at, double rho) const {
  const RobotDescription& of = description_.robots[robot];
  const double c = std::cos(rho);
  const double s = std::sin(rho);
  const double x = (of.front - of.back) / 2;
  const double y = (of.right - of.left) / 2;
  return {.at = {at.x + x * c - y * s, at.y + x * s + y * c},
          .c = c,
          .s = s,
          .half_length = (of.front + of.back) / 2,
          .half_width = (of.right + of.left) / 2};
}

void World::State::advance(tims::Time to) {
  if (to <= now_) return;
  while (static_cast<std::int64_t>(history_.steps()) * kStep < to - begin_) step();
  now_ = to;
}

// Robots move first, then people, who see the new poses of the robots.
void World::State::step() {
  const tims::Time begin = begin_ + static_cast<std::int64_t>(history_.steps()) * kStep;
  for (std::size_t i = 0; i < robots_.size(); ++i) step_robot(i, begin);
  if (frozen_)
    people_.stand();
  else
    people_.step(surroundings(), contacts_);
  history_.begin_step();
  for (std::size_t i = 0; i < axes_.size(); ++i)
    history_.axis(i) = axes_[i].angle += axes_[i].rate * kStateSeconds;
  for (std::size_t i = 0; i < robots_.size(); ++i) history_.robot(i) = robots_[i].now;
  for (std::size_t i = 0; i < people_.size(); ++i) history_.person(i) = people_.figures()[i];
}

void World::State::step_robot(std::size_t number, tims::Time begin) {
  Robot& robot = robots_[number];
  const Movement m = robot.vehicle.step(begin);
  RobotSample next = robot.now;
  next.jumped = RobotSample::kNoJump;
  const Pose to = moved({.x = robot.now.at.x, .y = robot.now.at.y, .rho = robot.now.rho}, m);
  next.at = {to.x, to.y};
  next.rho = to.rho;
  next.vx = m.x / kStateSeconds;
  next.vy = m.y / kStateSeconds;
  next.omega = m.rho / kStateSeconds;
  const bool moves = m.x != 0 || m.y != 0 || m.rho != 0;
  const Box there = moves ? hull(number, next.at, next.rho) : hulls_[number];
  const Met met = moves ? collision(number, there) : Met::kNothing;
  if (met != Met::kNothing) {
    block(number, met, there);
    next.at = robot.now.at;
    next.rho = robot.now.rho;
    next.vx = next.vy = next.omega = 0;
  } else {
    robot.is_blocked = false;
    ++robot.free_steps;
    hulls_[number] = there;
    robot.travelled += std::hypot(m.x, m.y);
  }
  settle(number, next);
}

// Sets the new state, with accelerations from the difference to the last one.
void World::State::settle(std::size_t number, const RobotSample& next) {
  RobotSample& now = robots_[number].now;
  const double ax = (next.vx - now.vx) / kStateSeconds - next.omega * next.vy;
  const double ay = (next.vy - now.vy) / kStateSeconds + next.omega * next.vx;
  const double alpha = (next.omega - now.omega) / kStateSeconds;
  now = next;
  now.ax = ax;
  now.ay = ay;
  now.alpha = alpha;
}

// Counts one contact while the robot stays there or jitters. People who walk into it are counted by
// People.
void World::State::block(std::size_t number, Met met, const Box& there) {
  Robot& robot = robots_[number];
  robot.is_blocked = true;
  if (met == Met::kPerson && people_.walked_against(there)) return;
  const bool is_new = robot.free_steps >= kFreeAfter;
  robot.free_steps = 0;
  if (!is_new) return;
  Contacts& contacts = contacts_[number];
  switch (met) {
    case Met::kObstacle:
      ++contacts.obstacles;
      break;
    case Met::kPerson:
      ++contacts.people;
      break;
    case Met::kRobot:
      ++contacts.robots;
      break;
    default:
      ++contacts.walls;
  }
}

void World::State::turn(const SensorId& sensor, double rate) {
  const auto axis = sensor_at(sensor).axis;
  if (axis && std::isfinite(rate)) axes_[*axis].rate = rate;
}

bool World::State::is_on_ground(const Box& hull) const {
  const double x = std::abs(hull.c) * hull.half_length + std::abs(hull.s) * hull.half_width;
  const double y = std::abs(hull.s) * hull.half_length + std::abs(hull.c) * hull.half_width;
  const auto& [from, to] = description_.ground;
  return hull.at.x - x >= from.x && hull.at.x + x <= to.x && hull.at.y - y >= from.y &&
         hull.at.y + y <= to.y;
}

Met World::State::collision(std::size_t robot, const Box& hull) const {
  if (!is_on_ground(hull)) return Met::kWall;
  if (const Met met = scenery_.touches(hull); met != Met::kNothing) return met;
  for (const Solid& solid : solids_)
    if (overlap(hull, solid)) return Met::kObstacle;
  for (const Figure& person : people_.figures())
    if (overlap(hull, Circle{person.at, kBodyRadius})) return Met::kPerson;
  for (std::size_t i = 0; i < hulls_.size(); ++i)
    if (i != robot && overlap(hull, hulls_[i])) return Met::kRobot;
  return Met::kNothing;
}

tims::Result<void> World::State::place(std::size_t number, const Pose& pose) {
  if (!std::isfinite(pose.x) || !std::isfinite(pose.y) || !std::isfinite(pose.rho))
    return tims::Error(tims::Errc::kInvalidArgument, "the pose is not a number");
  const Box there = hull(number, {pose.x, pose.y}, pose.rho);
  if (const Met met = collision(number, there); met != Met::kNothing)
    return tims::Error(tims::Errc::kRefused,
                       fmt::format("robot {} would stand in {} at x {:.0f} y {:.0f}",
                                   description_.robots[number].name, what(met), pose.x, pose.y));
  Robot& robot = robots_[number];
  robot.vehicle.stop();
  robot.now = {.at = {pose.x, pose.y}, .rho = pose.rho, .jumped = age(now_)};
  robot.is_blocked = false;
  robot.free_steps = kFreeAfter;
  history_.robot(number) = robot.now;
  hulls_[number] = there;
  return {};
}

tims::Result<std::size_t> World::State::put(const ObstacleDescription& obstacle) {
  const auto is_length = [](double mm) { return mm > 0 && mm <= kPutLargest; };
  if (!std::isfinite(obstacle.at.x) || !std::isfinite(obstacle.at.y) ||
      !std::isfinite(obstacle.rho) || !is_length(obstacle.length) || !is_length(obstacle.width) ||
      !is_length(obstacle.radius) || !is_length(obstacle.height))
    return tims::Error(tims::Errc::kInvalidArgument,
                       "an obstacle needs a position, and sizes above 0 and up to 100 m");
  const Solid solid = Solid::of(obstacle);
  for (std::size_t i = 0; i < hulls_.size(); ++i)
    if (overlap(hulls_[i], solid))
      return tims::Error(tims::Errc::kRefused,
                         "robot " + description_.robots[i].name + " is at this place");
  for (const Figure& person : people_.figures())
    if (distance(person.at, solid) < kPersonRadius)
      return tims::Error(tims::Errc::kRefused, "a person is at this place");
  if (solids_.size() == kPutMax)
    return tims::Error(tims::Errc::kFull, fmt::format("{} obstacles were placed and not removed: "
                                                      "remove one",
                                                      kPutMax));
  forget_obstacles();
  put_.push_back({.id = next_put_, .description = obstacle, .solid = solid, .from = now_});
  collect_obstacles();
  return std::size_t{next_put_++};
}

bool World::State::remove(std::size_t obstacle) {
  for (Put& put : put_) {
    if (put.id != obstacle || put.to != tims::kNever) continue;
    put.to = now_;
    collect_obstacles();
    return true;
  }
  return false;
}

// Deletes obstacles that are older than the history, and if that is not enough, the one that was
// removed first.
void World::State::forget_obstacles() {
  std::erase_if(
      put_, [&](const Put& put) { return put.to != tims::kNever && put.to < now_ - kRemembered; });
  if (put_.size() < kPutKept) return;
  put_.erase(std::ranges::min_element(put_, {}, &Put::to));
}

void World::State::collect_obstacles() {
  solids_.clear();
  for (const Put& put : put_)
    if (put.to == tims::kNever) solids_.push_back(put.solid);
}

void World::State::truth(Truth& out) const {
  out.at = now_;
  out.people_frozen = frozen_;
  out.robots.resize(robots_.size());
  const History::Moment now = moment(now_);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const RobotSample sample = history_.robot(i, now);
    out.robots[i] = {.pose = {.x = sample.at.x, .y = sample.at.y, .rho = heading(sample.rho)},
                     .vx = sample.vx,
                     .vy = sample.vy,
                     .omega = sample.omega,
                     .travelled = robots_[i].travelled,
                     .is_blocked = robots_[i].is_blocked,
                     .contacts = contacts_[i]};
  }
  out.people.resize(people_.size());
  for (std::size_t i = 0; i < people_.size(); ++i) {
    const Figure person = history_.person(i, now);
    out.people[i] = {i, person.at, person.vx, person.vy, heading(person.rho)};
  }
  out.obstacles.clear();
  for (const Put& put : put_)
    if (put.to == tims::kNever) out.obstacles.push_back({put.id, put.description});
}

}  // namespace rack::world
