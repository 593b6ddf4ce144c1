// The state of a world and its steps. Only for world.cpp and sensing.cpp.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "components/geometry/coordinates.h"
#include "components/world/core/history.h"
#include "components/world/core/people.h"
#include "components/world/core/scenery.h"
#include "components/world/core/vehicle.h"
#include "components/world/core/world.h"

namespace rack::world {

class World::State {
 public:
  State(WorldDescription description, tims::Time begin);
  // The reason why the description is not valid, if it is not.
  [[nodiscard]] std::optional<std::string> problem() const;

  [[nodiscard]] const WorldDescription& description() const { return description_; }
  [[nodiscard]] tims::Time now() const { return now_; }
  void advance(tims::Time to);

  void turn(const SensorId& sensor, double rate);
  [[nodiscard]] double axis(const SensorId& id, tims::Time at) const;
  Vehicle& vehicle(std::size_t robot) { return robots_[robot].vehicle; }
  [[nodiscard]] const Vehicle& vehicle(std::size_t robot) const { return robots_[robot].vehicle; }

  tims::Result<void> place(std::size_t number, const Pose& pose);
  tims::Result<std::size_t> put(const ObstacleDescription& obstacle);
  bool remove(std::size_t obstacle);
  void freeze_people(bool frozen) { frozen_ = frozen; }
  void truth(Truth& out) const;

  // --- sensing (sensing.cpp)

  [[nodiscard]] RayHit look(const SensorId& id, const RayDirection& direction, tims::Time at) const;
  [[nodiscard]] Echo measure(const SensorId& id, const RayDirection& direction,
                             tims::Time at) const;
  [[nodiscard]] SatelliteFix satellite_fix(const SensorId& id, tims::Time at) const;
  [[nodiscard]] InertialMeasurement inertial(const SensorId& id, tims::Time at) const;
  [[nodiscard]] double compass(const SensorId& id, tims::Time at) const;
  [[nodiscard]] Pose sensor_pose(const SensorId& id, tims::Time at) const;
  [[nodiscard]] Pose pose(std::size_t robot, tims::Time at) const;
  void view(const SensorId& id, tims::Time at, View& out) const;
  void plug(const SensorId& sensor, bool plugged) { sensor_at(sensor).is_plugged = plugged; }
  [[nodiscard]] bool is_plugged(const SensorId& sensor) const {
    return sensor_at(sensor).is_plugged;
  }

 private:
  struct Sensor {
    explicit Sensor(const SensorDescription& of, std::uint64_t seed);
    SensorDescription is;
    std::uint64_t seed;
    std::array<std::array<double, 3>, 3> turn{};  // from its frame to the robot's
    std::optional<std::size_t> axis{};            // index in axes_
    bool is_plugged = true;
  };
  struct Axis {
    double angle = 0;
    double rate = 0;
  };
  struct Robot {
    Robot(const RobotDescription& of, std::uint64_t seed);
    Vehicle vehicle;
    std::vector<Sensor> sensors;
    RobotSample now{};  // the newest state
    double travelled = 0;
    bool is_blocked = false;
    std::uint64_t free_steps = 0;
  };
  // An obstacle placed by a command. It is kept as long as a sensor may look back at it.
  struct Put {
    std::size_t id = 0;
    ObstacleDescription description{};
    Solid solid{};
    tims::Time from{};
    tims::Time to = tims::kNever;
  };

  [[nodiscard]] const Sensor& sensor_at(const SensorId& id) const {
    return robots_[id.robot].sensors[id.sensor];
  }
  Sensor& sensor_at(const SensorId& id) { return robots_[id.robot].sensors[id.sensor]; }
  [[nodiscard]] tims::Time seen_at(tims::Time at) const { return std::min(at, now_); }
  [[nodiscard]] tims::Duration age(tims::Time at) const { return at - begin_; }
  [[nodiscard]] History::Moment moment(tims::Time at) const { return history_.moment(seen_at(at)); }

  [[nodiscard]] People::Surroundings surroundings() const { return {scenery_, hulls_, solids_}; }
  [[nodiscard]] Box hull(std::size_t robot, const MapPoint& at, double rho) const;
  void step();
  void step_robot(std::size_t number, tims::Time begin);
  void block(std::size_t number, Met met, const Box& there);
  // The kind of object that a hull would touch; other robots only at their current places.
  [[nodiscard]] Met collision(std::size_t robot, const Box& hull) const;
  [[nodiscard]] bool is_on_ground(const Box& hull) const;
  void settle(std::size_t number, const RobotSample& next);
  void collect_obstacles();
  void forget_obstacles();

  // Hits of moving and placed objects before `best`.
  void meet_obstacles(const Ray& ray, tims::Time at, RayHit& best) const;
  void meet_people(const Ray& ray, const History::Moment& when, RayHit& best) const;
  void meet_robots(const Ray& ray, std::size_t own, const History::Moment& when,
                   RayHit& best) const;

  WorldDescription description_;
  tims::Time begin_;
  tims::Time now_;
  Scenery scenery_;
  std::vector<Robot> robots_;
  std::vector<Axis> axes_;
  std::vector<Box> hulls_;  // of the newest state
  std::vector<Contacts> contacts_;
  People people_;
  History history_;
  std::vector<Put> put_;
  std::vector<Solid> solids_;  // of the placed obstacles that exist now
  std::size_t next_put_ = 1;
  bool frozen_ = false;
  navigation::Grid grid_{};  // of satellites
  navigation::PlanePoint grid_origin_{};
};

}  // namespace rack::world
