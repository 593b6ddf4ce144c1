#include "components/world/core/world.h"

#include <algorithm>
#include <utility>

#include "components/world/core/state.h"

namespace rack::world {

World::World(std::unique_ptr<State> state) : state_(std::move(state)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

tims::Result<World> World::make(WorldDescription description, tims::Time begin) {
  auto state = std::make_unique<State>(std::move(description), begin);
  if (const auto problem = state->problem())
    return tims::Error(tims::Errc::kInvalidArgument, *problem);
  return World(std::move(state));
}

const WorldDescription& World::description() const { return state_->description(); }

std::optional<std::size_t> World::find_robot(std::string_view name) const {
  const auto& robots = description().robots;
  const auto found = std::ranges::find(robots, name, &RobotDescription::name);
  if (found == robots.end()) return std::nullopt;
  return static_cast<std::size_t>(found - robots.begin());
}

std::optional<SensorId> World::find_sensor(std::string_view robot, std::string_view sensor) const {
  const auto number = find_robot(robot);
  if (!number) return std::nullopt;
  const auto& sensors = description().robots[*number].sensors;
  const auto found = std::ranges::find(sensors, sensor, &SensorDescription::name);
  if (found == sensors.end()) return std::nullopt;
  return SensorId{*number, static_cast<std::size_t>(found - sensors.begin())};
}

void World::advance(tims::Time to) { state_->advance(to); }
tims::Time World::now() const { return state_->now(); }

void World::drive(std::size_t robot, std::span<const double> motors, tims::Time at) {
  state_->vehicle(robot).drive(motors, at + description().robots[robot].lag);
}
void World::drive(std::size_t robot, const device::ChassisSpeed& speed, tims::Time at) {
  state_->vehicle(robot).drive(speed, at + description().robots[robot].lag);
}
const device::Wheels& World::wheels(std::size_t robot) const {
  return std::as_const(*state_).vehicle(robot).wheels();
}
std::span<const device::MotorMotion> World::motors(std::size_t robot) const {
  return std::as_const(*state_).vehicle(robot).motors();
}

void World::turn(const SensorId& sensor, double rate) { state_->turn(sensor, rate); }
double World::axis(const SensorId& sensor, tims::Time at) const { return state_->axis(sensor, at); }

RayHit World::look(const SensorId& sensor, const RayDirection& ray, tims::Time at) const {
  return state_->look(sensor, ray, at);
}
Echo World::measure(const SensorId& sensor, const RayDirection& ray, tims::Time at) const {
  return state_->measure(sensor, ray, at);
}
SatelliteFix World::satellite_fix(const SensorId& sensor, tims::Time at) const {
  return state_->satellite_fix(sensor, at);
}
InertialMeasurement World::inertial(const SensorId& sensor, tims::Time at) const {
  return state_->inertial(sensor, at);
}
double World::compass(const SensorId& sensor, tims::Time at) const {
  return state_->compass(sensor, at);
}
Pose World::sensor_pose(const SensorId& sensor, tims::Time at) const {
  return state_->sensor_pose(sensor, at);
}
void World::view(const SensorId& sensor, tims::Time at, View& out) const {
  state_->view(sensor, at, out);
}
Pose World::pose(std::size_t robot, tims::Time at) const { return state_->pose(robot, at); }

tims::Result<void> World::place(std::size_t robot, const Pose& pose) {
  return state_->place(robot, pose);
}
tims::Result<std::size_t> World::put(const ObstacleDescription& obstacle) {
  return state_->put(obstacle);
}
bool World::remove(std::size_t obstacle) { return state_->remove(obstacle); }
void World::freeze_people(bool frozen) { state_->freeze_people(frozen); }
void World::plug(const SensorId& sensor, bool plugged) { state_->plug(sensor, plugged); }
bool World::is_plugged(const SensorId& sensor) const { return state_->is_plugged(sensor); }

Truth World::make_truth() const {
  Truth truth;
  truth.obstacles.reserve(kPutMax);
  state_->truth(truth);
  return truth;
}
void World::truth(Truth& out) const { state_->truth(out); }

}  // namespace rack::world
