// Sensing. A ray is given in the sensor's frame, transformed to the robot's frame by the mount, and
// to the world by the pose of the robot at that time. It is traced through the scenery over ground,
// and then against moving objects; the nearest hit counts.
#include <algorithm>
#include <cmath>

#include "components/world/core/noise.h"
#include "components/world/core/state.h"
#include "components/world/core/view.h"

namespace rack::world {

namespace {

using Vector = std::array<double, 3>;

constexpr double kGravity = 9806.65;  // mm/s2
constexpr double kVertical = 1e-9;

// Rotation about z, then y, then x, the order of a mount.
std::array<Vector, 3> turn_of(const Pose& mount) {
  const double cz = std::cos(mount.rho);
  const double sz = std::sin(mount.rho);
  const double cy = std::cos(mount.psi);
  const double sy = std::sin(mount.psi);
  const double cx = std::cos(mount.phi);
  const double sx = std::sin(mount.phi);
  return {{{cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx},
           {sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx},
           {-sy, cy * sx, cy * cx}}};
}

Vector turned(const std::array<Vector, 3>& turn, const Vector& v) {
  Vector result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = turn[i][0] * v[0] + turn[i][1] * v[1] + turn[i][2] * v[2];
  return result;
}

Vector turned_back(const std::array<Vector, 3>& turn, const Vector& v) {
  Vector result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = turn[0][i] * v[0] + turn[1][i] * v[1] + turn[2][i] * v[2];
  return result;
}

// Rotations by roll, pitch and yaw are clockwise when looking along the axis.
Vector turned_about(TurnedAbout axis, double angle, const Vector& v) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  switch (axis) {
    case TurnedAbout::kRoll:
      return {v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]};
    case TurnedAbout::kPitch:
      return {c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]};
    case TurnedAbout::kYaw:
      return {c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
    case TurnedAbout::kNothing:
      break;
  }
  return v;
}

// Whether a ray passes within this distance of a point, ahead.
bool passes(const Ray& ray, const MapPoint& at, double near) {
  const double x = at.x - ray.from.x;
  const double y = at.y - ray.from.y;
  return std::abs(x * ray.y - y * ray.x) <= near && x * ray.x + y * ray.y >= -near;
}

}  // namespace

World::State::Sensor::Sensor(const SensorDescription& of, std::uint64_t stirred_seed)
    : is(of), seed(stirred_seed), turn(turn_of(of.mount)) {}

RayHit World::State::look(const SensorId& id, const RayDirection& direction, tims::Time at) const {
  const Sensor& sensor = sensor_at(id);
  const History::Moment when = moment(at);
  const RobotSample robot = history_.robot(id.robot, when);
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  const double level = std::cos(direction.elevation);
  Vector v =
      turned(sensor.turn, {level * std::cos(direction.azimuth), level * std::sin(direction.azimuth),
                           -std::sin(direction.elevation)});
  if (sensor.axis) v = turned_about(sensor.is.axis.about, history_.axis(*sensor.axis, when), v);
  const double x = v[0] * c - v[1] * s;
  const double y = v[0] * s + v[1] * c;
  const double flat = std::hypot(x, y);
  const Pose& mount = sensor.is.mount;
  const double most = sensor.is.max_range;
  RayHit best{.range = kNoHit};
  if (flat < kVertical) {
    if (v[2] > 0 && -mount.z <= most) return {.range = -mount.z, .met = Met::kGround};
    return {.range = most};
  }
  const Ray ray{
      .from = {robot.at.x + mount.x * c - mount.y * s, robot.at.y + mount.x * s + mount.y * c},
      .x = x / flat,
      .y = y / flat,
      .height = -mount.z,
      .climb = -v[2] / flat,
      .reach = most * flat};
  // Over ground, up to its end.
  const Scenery::Hit standing = scenery_.cast(ray);
  best = {.range = standing.range, .met = standing.met};
  if (ray.climb < 0 && -ray.height / ray.climb < best.range)
    best = {.range = -ray.height / ray.climb, .met = Met::kGround};
  meet_obstacles(ray, seen_at(at), best);
  meet_people(ray, when, best);
  meet_robots(ray, id.robot, when, best);
  if (best.range > ray.reach) return {.range = most};
  best.range /= flat;
  return best;
}

void World::State::meet_obstacles(const Ray& ray, tims::Time at, RayHit& best) const {
  for (const Put& put : put_) {
    if (at < put.from || at >= put.to) continue;
    if (const double range = meets(ray, put.solid); range < best.range)
      best = {.range = range, .met = Met::kObstacle, .id = put.id};
  }
}

void World::State::meet_people(const Ray& ray, const History::Moment& when, RayHit& best) const {
  constexpr double kNear = 500;  // mm: arms, legs and the movement within a step
  for (std::size_t i = 0; i < people_.size(); ++i) {
    if (!passes(ray, history_.person_about(i, when), kNear)) continue;
    const double range = meets(ray, history_.person(i, when), description_.people.height);
    if (range < best.range) best = {.range = range, .met = Met::kPerson, .id = i};
  }
}

void World::State::meet_robots(const Ray& ray, std::size_t own, const History::Moment& when,
                               RayHit& best) const {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i == own) continue;
    const RobotDescription& of = description_.robots[i];
    const RobotSample robot = history_.robot(i, when);
    const double reach = std::hypot(std::max(of.front, of.back), std::max(of.left, of.right));
    if (!passes(ray, robot.at, reach)) continue;
    const double range = meets(ray, inside(ray, hull(i, robot.at, robot.rho)), of.height);
    if (range < best.range) best = {.range = range, .met = Met::kRobot, .id = i};
  }
}

Echo World::State::measure(const SensorId& id, const RayDirection& direction, tims::Time at) const {
  const Sensor& sensor = sensor_at(id);
  const NoiseDescription& noise = sensor.is.noise;
  Echo echo{.truth = look(id, direction, at)};
  Random random = noise_of_ray(sensor.seed, age(seen_at(at)), direction);
  const auto luck = static_cast<double>(random.uniform());
  if (luck < noise.dropped_share) return echo;
  if (luck < noise.dropped_share + noise.short_share) {
    echo.range = echo.truth.range * static_cast<double>(random.uniform());
    echo.is_valid = true;
    return echo;
  }
  if (echo.truth.met == Met::kNothing) return echo;
  echo.range = std::max(0.0, echo.truth.range + noise.range * static_cast<double>(random.normal()));
  echo.is_valid = echo.range <= sensor.is.max_range;
  return echo;
}

SatelliteFix World::State::satellite_fix(const SensorId& id, tims::Time at) const {
  const Sensor& sensor = sensor_at(id);
  const tims::Duration when = age(seen_at(at));
  const auto covers = [&](const Outage& outage) { return when >= outage.from && when < outage.to; };
  if (std::ranges::any_of(sensor.is.outages, covers)) return {};
  const NoiseDescription& noise = sensor.is.noise;
  Random random = noise_at(sensor.seed, when);
  const auto error = [&](std::uint64_t axis) {
    return noise.position * static_cast<double>(random.normal()) +
           noise.drift * drift(stirred(sensor.seed, axis), when);
  };
  const Pose pose = sensor_pose(id, at);
  const RobotSample robot = history_.robot(id.robot, moment(at));
  constexpr double kMetre = 1000;
  const double north = (pose.x + error(1)) / kMetre;
  const double east = (pose.y + error(2)) / kMetre;
  const double up = (1.5 * error(3) - pose.z) / kMetre;
  const navigation::Geodetic place =
      unproject({grid_origin_.north + north, grid_origin_.east + east}, grid_);
  const double speed = std::hypot(robot.vx, robot.vy);
  constexpr double kMoves = 1;  // mm/s
  const double drift_angle = speed > kMoves ? std::atan2(robot.vy, robot.vx) : 0;
  return {.is_valid = true,
          .latitude = place.latitude,
          .longitude = place.longitude,
          .altitude = description_.origin.altitude + up,
          .course = heading(robot.rho + drift_angle),
          .speed = speed,
          .deviation = std::hypot(noise.position, noise.drift)};
}

InertialMeasurement World::State::inertial(const SensorId& id, tims::Time at) const {
  const Sensor& sensor = sensor_at(id);
  const NoiseDescription& noise = sensor.is.noise;
  const RobotSample robot = history_.robot(id.robot, moment(at));
  const Pose& mount = sensor.is.mount;
  const tims::Duration when = age(seen_at(at));
  Random random = noise_at(sensor.seed, when);
  // Centrifugal acceleration away from the reference point.
  const double square = robot.omega * robot.omega;
  const Vector acceleration{robot.ax - robot.alpha * mount.y - square * mount.x,
                            robot.ay + robot.alpha * mount.x - square * mount.y, -kGravity};
  InertialMeasurement result;
  result.rates = turned_back(sensor.turn, {0, 0, robot.omega});
  result.accelerations = turned_back(sensor.turn, acceleration);
  for (std::size_t i = 0; i < 3; ++i) {
    result.rates[i] += noise.rate * static_cast<double>(random.normal()) +
                       noise.rate_bias * drift(stirred(sensor.seed, i), when);
    result.accelerations[i] += noise.acceleration * static_cast<double>(random.normal());
  }
  const auto angle = [&] { return noise.angle * static_cast<double>(random.normal()); };
  result.phi = signed_angle(mount.phi + angle());
  result.psi = signed_angle(mount.psi + angle());
  result.rho = heading(robot.rho + mount.rho + angle());
  return result;
}

double World::State::compass(const SensorId& id, tims::Time at) const {
  const Sensor& sensor = sensor_at(id);
  Random random = noise_at(sensor.seed, age(seen_at(at)));
  return heading(sensor_pose(id, at).rho +
                 sensor.is.noise.angle * static_cast<double>(random.normal()));
}

double World::State::axis(const SensorId& id, tims::Time at) const {
  const auto axis = sensor_at(id).axis;
  return axis ? history_.axis(*axis, moment(at)) : 0;
}

Pose World::State::pose(std::size_t robot, tims::Time at) const {
  const RobotSample sample = history_.robot(robot, moment(at));
  return {.x = sample.at.x, .y = sample.at.y, .rho = heading(sample.rho)};
}

Pose World::State::sensor_pose(const SensorId& id, tims::Time at) const {
  return pose(id.robot, at) + sensor_at(id).is.mount;
}

void World::State::view(const SensorId& id, tims::Time at, View& out) const {
  const History::Moment when = moment(at);
  const RobotSample own = history_.robot(id.robot, when);
  const Sensor& sensor = sensor_at(id);
  out.age = age(seen_at(at));
  const Pose pose = sensor_pose(id, at);
  out.from = {pose.x, pose.y, pose.z};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector column = turned_about(TurnedAbout::kYaw, own.rho,
                                       {sensor.turn[0][i], sensor.turn[1][i], sensor.turn[2][i]});
    for (std::size_t k = 0; k < 3; ++k) out.turn[k][i] = column[k];
  }
  out.robots.clear();
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i == id.robot) continue;
    const RobotSample robot = history_.robot(i, when);
    out.robots.push_back({i, hull(i, robot.at, robot.rho)});
  }
  out.people.clear();
  for (std::size_t i = 0; i < people_.size(); ++i) out.people.push_back(history_.person(i, when));
  out.obstacles.clear();
  for (const Put& put : put_)
    if (seen_at(at) >= put.from && seen_at(at) < put.to) out.obstacles.push_back(put.description);
}

}  // namespace rack::world
