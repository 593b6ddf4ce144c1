// What a world is made of, as its file says it (world_file.h): walls, obstacles, people, robots
// with their sensors. Plain values. Lengths in mm, angles in rad, both as RACK has them: x to the
// north and y to the east, or x forward and y to the right; angles clockwise; z down, so that what
// stands 300 mm above the ground has z = -300.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "tims/time.h"

namespace rack::world {

// --- what stands

struct WallDescription {
  MapPoint from{};
  MapPoint to{};
  double height = 2500;
};

enum class Shape : std::uint8_t { kBox, kCircle };

struct ObstacleDescription {
  Shape shape = Shape::kBox;
  MapPoint at{};        // its middle
  double rho = 0;       // of a box: where its length points to
  double length = 500;  // of a box
  double width = 500;   // of a box
  double radius = 250;  // of a circle
  double height = 1000;
};

// --- people

struct Area {
  MapPoint from{};  // the corner with the smaller coordinates
  MapPoint to{};
};

// Somebody who goes from place to place, in turn and again and again.
struct WalkDescription {
  std::vector<MapPoint> places{};
  tims::Duration pause = std::chrono::seconds(3);  // at each of them
};

struct PeopleDescription {
  std::size_t count = 0;  // of those who go where they like
  double speed = 1200;    // mm/s; each has a fifth more or less
  double height = 1700;
  tims::Duration pause_max = std::chrono::seconds(10);  // at the place that was wanted
  double avoids_share = 0.8;             // of meetings with robots in which they stop or step aside
  std::optional<Area> area{};            // where they stay; none: wherever there is room
  std::vector<WalkDescription> walks{};  // a person each, before the others
};

// --- robots

enum class DriveKind : std::uint8_t { kDifferential, kAckermann, kDoubleAckermann };

// How the ground takes what the wheels do. Zeros: the ground moves below the robot exactly as the
// wheels turn, and odometry is the truth.
struct SlipDescription {
  double way = 0;         // share of the way that is lost: 0.02 makes 980 mm of a metre
  double turn = 0;        // share of each turn that is lost
  double way_noise = 0;   // mm, standard deviation after a metre; grows with the root of the way
  double turn_noise = 0;  // rad, after a metre, alike; a turn of 1 rad counts as half a metre
};

struct NoiseDescription {
  // Of rays.
  double range = 0;          // mm, standard deviation
  double short_share = 0;    // of the rays: they end somewhere on their way (rain, dust)
  double dropped_share = 0;  // of the rays: nothing comes back
  // Of a satellite receiver.
  double position = 0;  // mm, standard deviation of each fix
  double drift = 0;     // mm, standard deviation of what all fixes of some minutes share
  // Of inertial sensors and compasses.
  double angle = 0;         // rad: roll, pitch, heading
  double rate = 0;          // rad/s
  double rate_bias = 0;     // rad/s, standard deviation of an error that changes in minutes
  double acceleration = 0;  // mm/s2
};

enum class SensorKind : std::uint8_t {
  kScanner,    // rays in a plane
  kScanner3d,  // rays in all directions
  kSatellite,
  kInertial,
  kCompass,
  kCamera,
};

struct Outage {
  tims::Duration from{};  // after the world's begin
  tims::Duration to{};
};

// What turns a scanner, about an axis of the robot through the scanner's place.
enum class TurnedAbout : std::uint8_t { kNothing, kRoll, kPitch, kYaw };

struct AxisDescription {
  TurnedAbout about = TurnedAbout::kNothing;  // roll: x, pitch: y, yaw: z of the robot
  double gear_ratio = 1;                      // turns of its motor for one of the axis
  // For whoever makes its drive: emulator and line.
  std::string device{};
  std::string line{};
};

struct SensorDescription {
  std::string name{};
  SensorKind kind = SensorKind::kScanner;
  // On the robot, from its reference point. phi: rolled to the right, psi: looking up.
  Pose mount{};
  AxisDescription axis{};    // at angle 0 the sensor is as its mount says
  double max_range = 80000;  // of rays
  NoiseDescription noise{};
  tims::Duration lag{};           // between a measurement and its telegram; the world only says it
  std::vector<Outage> outages{};  // of satellites: no fix then
  tims::Duration period{};        // of a satellite receiver's fixes; 0: as it is made
  // For whoever makes the device: which emulator, and where its line is. Not looked at here.
  std::string device{};
  std::string line{};
};

struct RobotDescription {
  std::string name{};
  DriveKind kind = DriveKind::kDifferential;
  Pose start{};
  // Of its wheels: the reference point lies between two driven wheels, on the rear axle, or in the
  // middle between two steered axles (components/geometry/wheels.h).
  double track = 400;
  double base = 1200;
  double steer_max = 0.4;  // rad
  // Between its motors and the wheels, where emulated motors tell turns of their shafts.
  double wheel_radius = 110;
  double gear_ratio = 1;   // turns of a motor for one of its wheel
  double steer_ratio = 1;  // turns of a motor for one of the steering
  // Its hull, from the reference point.
  double front = 250;
  double back = 250;
  double left = 250;
  double right = 250;
  double height = 600;
  // What its motors can; 0: what they are told at once.
  double acceleration = 0;   // mm/s2, of each rim
  double deceleration = 0;   // mm/s2; 0: as acceleration
  double steering_rate = 0;  // rad/s
  tims::Duration lag{};      // until they begin to do what they are told
  SlipDescription slip{};
  // For whoever makes the base: emulator and line, as of sensors.
  std::string device{};
  std::string line{};
  std::vector<SensorDescription> sensors{};
};

// --- all of it

// The place on Earth that is x = 0, y = 0. The world lies on the plane of that place's UTM zone: x
// is its north, y its east. Position shows the same numbers with the reference UTM, this zone and
// band, and these northing and easting as its offset.
struct Origin {
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double altitude = 0;   // m
};

struct WorldDescription {
  std::string name{};
  std::uint64_t seed = 1;
  Area ground{{-50000, -50000}, {50000, 50000}};  // nothing moves beyond
  Origin origin{};
  std::vector<WallDescription> walls{};
  std::vector<ObstacleDescription> obstacles{};
  PeopleDescription people{};
  std::vector<RobotDescription> robots{};
};

}  // namespace rack::world
