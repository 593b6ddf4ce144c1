// The one world that all robots of a simulation live in, and the only one who knows where everybody
// is. It has walls (of floor plans, extruded), obstacles, people who walk about, and robots whose
// wheels do what their devices say; it answers what a device would see at a time, and what is true.
// Components that crash or come late change nothing in it. Pure.
//
// Time goes on in steps of 5 ms from the begin of the world, as far as advance() says and at most
// one step further; in between everything moves on straight lines. All that happens follows from
// the description, its seed, and what was commanded when: the same again in any slices of
// advance(). Noise of a measurement follows from the sensor, the time and the ray, so that it is
// the same in whichever order sensors are asked. What moved in the last second is kept: a device
// that turns a mirror asks for each ray at the ray's own time, one with a lag for what was.
//
// A robot stops where its hull would touch something: its wheels turn on, and the contact is
// counted. The ground is flat; a robot does not tilt, its sensors may.
//
// Nothing is allocated once it is made, but for the texts of errors.
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

#include "components/geometry/wheels.h"
#include "components/world/core/description.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::world {

inline constexpr tims::Duration kStep = std::chrono::milliseconds(5);
inline constexpr tims::Duration kRemembered = std::chrono::seconds(1);
inline constexpr std::size_t kPutMax = 256;  // obstacles that were put and not removed
inline constexpr std::size_t kMotorsMax = 6;

// Numbers as in the description.
struct SensorId {
  std::size_t robot = 0;
  std::size_t sensor = 0;
  bool operator==(const SensorId&) const = default;
};

// --- what devices see

enum class Met : std::uint8_t { kNothing, kWall, kObstacle, kPerson, kRobot, kGround };

struct RayHit {
  double range = 0;  // mm; the sensor's largest when it met nothing
  Met met = Met::kNothing;
  std::size_t id = 0;  // of a person or robot, and of an obstacle that was put
};

struct Echo {
  RayHit truth{};
  double range = 0;       // mm, as it is measured
  bool is_valid = false;  // something came back
};

// One direction of a sensor, in its own frame.
struct RayDirection {
  double azimuth = 0;    // rad, clockwise from where it looks
  double elevation = 0;  // rad, up
};

struct SatelliteFix {
  bool is_valid = false;
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double altitude = 0;   // m
  double course = 0;     // rad, where it moves to; of the world's grid, as RACK's Position takes it
  double speed = 0;      // mm/s
  double deviation = 0;  // mm, of noise and drift
};

// In the sensor's frame: x forward, y to the right, z down.
struct InertialMeasurement {
  std::array<double, 3> rates{};          // rad/s about x, y, z
  std::array<double, 3> accelerations{};  // mm/s2, as a mass on springs feels it: at rest -g in z
  double phi = 0;                         // rad, attitude
  double psi = 0;
  double rho = 0;
};

// --- what is true

struct MotorState {
  double speed = 0;  // mm/s of the rim; of steering rad/s
  double way = 0;    // mm of the rim since the begin; of steering its angle, rad
};

struct Contacts {
  std::uint64_t walls = 0;  // and the end of the ground
  std::uint64_t obstacles = 0;
  std::uint64_t people = 0;
  std::uint64_t robots = 0;
  // People who walked against it: not its fault.
  std::uint64_t bumped = 0;

  [[nodiscard]] std::uint64_t own() const { return walls + obstacles + people + robots; }
  bool operator==(const Contacts&) const = default;
};

struct RobotTruth {
  Pose pose{};
  double vx = 0;     // mm/s, forward, over ground
  double vy = 0;     // mm/s, to the right
  double omega = 0;  // rad/s
  double way = 0;    // mm, over ground, since the begin
  bool is_blocked = false;
  Contacts contacts{};
};

struct PersonTruth {
  std::size_t id = 0;
  MapPoint at{};
  double vx = 0;   // mm/s to the north
  double vy = 0;   // mm/s to the east
  double rho = 0;  // where it looks
};

struct PutObstacle {
  std::size_t id = 0;  // never given again
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
  // kInvalidArgument says what of it cannot be: a robot in a wall, people without room.
  static tims::Result<World> make(WorldDescription description, tims::Time begin);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  [[nodiscard]] const WorldDescription& description() const;
  [[nodiscard]] std::optional<std::size_t> find_robot(std::string_view name) const;
  [[nodiscard]] std::optional<SensorId> find_sensor(std::string_view robot,
                                                    std::string_view sensor) const;

  // Time goes never back: what is earlier changes nothing.
  void advance(tims::Time to);
  [[nodiscard]] tims::Time now() const;

  // --- Driving. What the motors of a base do, or are told; they follow after the robot's lag, as
  // fast as it can. It begins with the first step that is not before `at`; what comes later than
  // its step, with the next one.

  // One number a motor, in the order of the robot's Wheels: mm/s of each rim (differential: left,
  // right), and rad of each steering. What is no number stays as it was, and so do motors left out.
  void drive(std::size_t robot, std::span<const double> motors, tims::Time at);
  // The same by a movement, for a base that is told one.
  void drive(std::size_t robot, const device::ChassisSpeed& speed, tims::Time at);
  [[nodiscard]] const device::Wheels& wheels(std::size_t robot) const;
  // What encoders of the motors would show now.
  [[nodiscard]] std::span<const MotorState> motors(std::size_t robot) const;
  // How fast the axis of a sensor turns from the next step on, rad/s. What is no number changes
  // nothing, and neither does a sensor without one.
  void turn(const SensorId& sensor, double rate);
  // Where it was, rad; 0 without one.
  [[nodiscard]] double axis(const SensorId& sensor, tims::Time at) const;

  // --- Seeing, at any time from a second ago until now: later is taken as now.

  // What a ray meets, without noise. A robot does not see itself.
  [[nodiscard]] RayHit look(const SensorId& sensor, const RayDirection& ray, tims::Time at) const;
  // The same as the sensor measures it.
  [[nodiscard]] Echo measure(const SensorId& sensor, const RayDirection& ray, tims::Time at) const;
  [[nodiscard]] SatelliteFix satellite_fix(const SensorId& sensor, tims::Time at) const;
  [[nodiscard]] InertialMeasurement inertial(const SensorId& sensor, tims::Time at) const;
  // Where the sensor's x axis points to, rad from north.
  [[nodiscard]] double compass(const SensorId& sensor, tims::Time at) const;
  // Where a sensor was; z, phi and psi are those of its mount, and so is all of it on an axis.
  [[nodiscard]] Pose sensor_pose(const SensorId& sensor, tims::Time at) const;

  // --- Commands. They hold from now on.

  // Puts a robot elsewhere, where it stands until its wheels do something. kRefused: there is no
  // room.
  tims::Result<void> place(std::size_t robot, const Pose& pose);
  // Its number. kRefused: somebody is there; kFull: kPutMax are there.
  tims::Result<std::size_t> put(const ObstacleDescription& obstacle);
  // Whether it was there.
  bool remove(std::size_t obstacle);
  void freeze_people(bool frozen);
  // Only kept: whoever makes the devices asks.
  void plug(const SensorId& sensor, bool plugged);
  [[nodiscard]] bool is_plugged(const SensorId& sensor) const;

  // --- The truth of now.

  // One with room for all there can be.
  [[nodiscard]] Truth make_truth() const;
  // Allocates nothing into one of make_truth().
  void truth(Truth& out) const;
  // Where a robot was; poses beyond what is remembered are the oldest.
  [[nodiscard]] Pose pose(std::size_t robot, tims::Time at) const;

 private:
  class State;
  explicit World(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace rack::world
