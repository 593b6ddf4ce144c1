// The simulated world: it is common to all robots of a simulation and is the only source of true
// positions. It has walls (extruded floor plans), obstacles, walking people, and robots whose
// wheels do what their devices command. It answers what a device measures at a time, and what is
// true. Components that crash or are late do not affect it. Pure.
//
// Time advances in steps of 5 ms since the start, up to the time of advance() and at most one step
// further; within a step, objects move on straight lines. Everything follows from the description,
// its seed, and the times of commands: the result is the same for any slices of advance(). The
// noise of a measurement depends on the sensor, the time and the ray, so that the order of queries
// does not matter. The last second is stored: a device with a rotating mirror queries each ray at
// the ray's own time, a device with a lag at an earlier time.
//
// A robot stops where its hull would touch an object: its wheels turn on, and the contact is
// counted. The ground is flat; a robot does not tilt, its sensors may.
//
// After construction nothing is allocated except the texts of errors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "components/geometry/motors.h"
#include "components/geometry/wheels.h"
#include "components/world/core/description.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::world {

inline constexpr tims::Duration kStep = std::chrono::milliseconds(5);
inline constexpr tims::Duration kRemembered = std::chrono::seconds(1);
inline constexpr std::size_t kPutMax = 256;  // maximum number of obstacles placed by commands
inline constexpr std::size_t kMotorsMax = 6;

// Indices of the description.
struct SensorId {
  std::size_t robot = 0;
  std::size_t sensor = 0;
  bool operator==(const SensorId&) const = default;
};

// --- measurements of devices

enum class Met : std::uint8_t { kNothing, kWall, kObstacle, kPerson, kRobot, kGround };

struct RayHit {
  double range = 0;  // mm; the sensor's maximum without a hit
  Met met = Met::kNothing;
  std::size_t id = 0;  // of a person, a robot, or a placed obstacle
};

struct Echo {
  RayHit truth{};
  double range = 0;       // mm, as measured
  bool is_valid = false;  // there is an echo
};

// One direction of a sensor, in its own frame.
struct RayDirection {
  double azimuth = 0;    // rad, clockwise from the sensor's x axis
  double elevation = 0;  // rad, up
};

struct SatelliteFix {
  bool is_valid = false;
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double altitude = 0;   // m
  double course = 0;  // rad, direction of movement in the world's grid, as RACK's Position uses it
  double speed = 0;   // mm/s
  double deviation = 0;  // mm, of noise and drift
};

// In the sensor's frame: x forward, y to the right, z down.
struct InertialMeasurement {
  std::array<double, 3> rates{};          // rad/s about x, y, z
  std::array<double, 3> accelerations{};  // mm/s2, proper acceleration: at rest -g in z
  double phi = 0;                         // rad, attitude
  double psi = 0;
  double rho = 0;
};

struct View;  // view.h

// --- the truth

struct Contacts {
  std::uint64_t walls = 0;  // including the border of the ground
  std::uint64_t obstacles = 0;
  std::uint64_t people = 0;
  std::uint64_t robots = 0;
  // People who walked into it: not caused by the robot.
  std::uint64_t bumped = 0;

  [[nodiscard]] std::uint64_t own() const { return walls + obstacles + people + robots; }
  bool operator==(const Contacts&) const = default;
};

struct RobotTruth {
  Pose pose{};
  double vx = 0;         // mm/s, forward, over ground
  double vy = 0;         // mm/s, to the right
  double omega = 0;      // rad/s
  double travelled = 0;  // mm, over ground, since the start
  bool is_blocked = false;
  Contacts contacts{};
};

struct PersonTruth {
  std::size_t id = 0;
  MapPoint at{};
  double vx = 0;   // mm/s to the north
  double vy = 0;   // mm/s to the east
  double rho = 0;  // direction of view
};

struct PutObstacle {
  std::size_t id = 0;  // never reused
  ObstacleDescription obstacle{};
};

struct Truth {
  tims::Time at{};
  bool people_frozen = false;
  std::vector<RobotTruth> robots{};
  std::vector<PersonTruth> people{};
  std::vector<PutObstacle> obstacles{};
};

// ---

class World {
 public:
  // The error kInvalidArgument names what is not possible: a robot in a wall, people without room.
  static tims::Result<World> make(WorldDescription description, tims::Time begin);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  [[nodiscard]] const WorldDescription& description() const;
  [[nodiscard]] std::optional<std::size_t> find_robot(std::string_view name) const;
  [[nodiscard]] std::optional<SensorId> find_sensor(std::string_view robot,
                                                    std::string_view sensor) const;

  // Time never goes back: an earlier time has no effect.
  void advance(tims::Time to);
  [[nodiscard]] tims::Time now() const;

  // --- Driving. Targets of the motors of a base; they follow after the robot's lag, within its
  // limits. A target takes effect with the first step that is not before `at`; one that is too late
  // takes effect with the next step.

  // One value per motor, in the order of the robot's Wheels: mm/s of each rim (differential: left,
  // right), and rad of each steering. Motors without a value, or with one that is not a number,
  // keep their target.
  void drive(std::size_t robot, std::span<const double> motors, tims::Time at);
  // The same by a movement, for a base that receives movements.
  void drive(std::size_t robot, const device::ChassisSpeed& speed, tims::Time at);
  [[nodiscard]] const device::Wheels& wheels(std::size_t robot) const;
  // The current values of the motors' encoders.
  [[nodiscard]] std::span<const device::MotorMotion> motors(std::size_t robot) const;
  // Sets the rate of a sensor's axis from the next step on, rad/s. No effect: a rate that is not a
  // number, or a sensor without an axis.
  void turn(const SensorId& sensor, double rate);
  // The angle of the axis, rad; 0 without an axis.
  [[nodiscard]] double axis(const SensorId& sensor, tims::Time at) const;

  // --- Sensing, at any time from a second ago until now; later times count as now.

  // The hit of a ray, without noise. A robot does not see itself.
  [[nodiscard]] RayHit look(const SensorId& sensor, const RayDirection& ray, tims::Time at) const;
  // The same with the noise of the sensor.
  [[nodiscard]] Echo measure(const SensorId& sensor, const RayDirection& ray, tims::Time at) const;
  [[nodiscard]] SatelliteFix satellite_fix(const SensorId& sensor, tims::Time at) const;
  [[nodiscard]] InertialMeasurement inertial(const SensorId& sensor, tims::Time at) const;
  // Direction of the sensor's x axis, rad from north.
  [[nodiscard]] double compass(const SensorId& sensor, tims::Time at) const;
  // The pose of a sensor; z, phi and psi are those of its mount, and with an axis all of it.
  [[nodiscard]] Pose sensor_pose(const SensorId& sensor, tims::Time at) const;

  // What a camera sees beside the static objects of the description. Allocates nothing when `out`
  // has been used before.
  void view(const SensorId& sensor, tims::Time at, View& out) const;

  // --- Commands. They take effect immediately.

  // Places a robot, where it stands until its wheels move. kRefused: there is no room.
  tims::Result<void> place(std::size_t robot, const Pose& pose);
  // Places an obstacle and returns its number. kRefused: a robot or person is there; kFull: kPutMax
  // are placed.
  tims::Result<std::size_t> put(const ObstacleDescription& obstacle);
  // Returns whether the obstacle existed.
  bool remove(std::size_t obstacle);
  void freeze_people(bool frozen);
  // Only stored, for the emulation of the devices.
  void plug(const SensorId& sensor, bool plugged);
  [[nodiscard]] bool is_plugged(const SensorId& sensor) const;

  // --- The current truth.

  // A message with capacity for all objects.
  [[nodiscard]] Truth make_truth() const;
  // Allocates nothing when `out` comes from make_truth().
  void truth(Truth& out) const;
  // The pose of a robot at a time; times before the history give the oldest pose.
  [[nodiscard]] Pose pose(std::size_t robot, tims::Time at) const;

 private:
  class State;
  explicit World(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace rack::world
