// The description of a simulated world, as read from its file (world_file.h): walls, obstacles,
// people, robots with their sensors. Plain values. Lengths in mm, angles in rad, in RACK's axes: x
// to the north and y to the east, or x forward and y to the right; angles clockwise; z down, so
// that the top of an object 300 mm above the ground has z = -300.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "components/vision/marker_map.h"
#include "tims/time.h"

namespace rack::world {

// --- static objects

struct WallDescription {
  MapPoint from{};
  MapPoint to{};
  double height = 2500;
};

enum class Shape : std::uint8_t { kBox, kCircle };

struct ObstacleDescription {
  Shape shape = Shape::kBox;
  MapPoint at{};        // its centre
  double rho = 0;       // of a box: direction of its length
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

// A person who walks to these places in turn, repeatedly.
struct WalkDescription {
  std::vector<MapPoint> places{};
  tims::Duration pause = std::chrono::seconds(3);  // at each of them
};

struct PeopleDescription {
  std::size_t count = 0;  // number of people with random destinations
  double speed = 1200;    // mm/s, mean; varies by a fifth between people
  double height = 1700;
  tims::Duration pause_max = std::chrono::seconds(10);  // at a destination
  double avoids_share = 0.8;   // share of meetings with robots in which they stop or step aside
  std::optional<Area> area{};  // area that they stay in; none: wherever there is room
  std::vector<WalkDescription> walks{};  // one person each, numbered before the others
};

// --- robots

enum class DriveKind : std::uint8_t { kDifferential, kAckermann, kDoubleAckermann };

// Slip between wheels and ground. Zeros: the robot moves exactly as its wheels turn, and odometry
// is exact.
struct SlipDescription {
  double distance = 0;  // share of the distance that is lost: 0.02 turns 1000 mm into 980 mm
  double turn = 0;      // share of each turn that is lost
  double distance_noise =
      0;  // mm, standard deviation after a metre; grows with the root of the distance
  double turn_noise = 0;  // rad, the same for the heading; a turn of 1 rad counts as half a metre
};

struct NoiseDescription {
  // Noise of rays.
  double range = 0;          // mm, standard deviation
  double short_share = 0;    // share of rays that end too early (rain, dust)
  double dropped_share = 0;  // share of rays without an echo
  // Noise of a satellite receiver.
  double position = 0;  // mm, standard deviation of each fix
  double drift = 0;     // mm, standard deviation of the common error of all fixes within minutes
  // Noise of inertial sensors and compasses.
  double angle = 0;         // rad: roll, pitch, heading
  double rate = 0;          // rad/s
  double rate_bias = 0;     // rad/s, standard deviation of an error that changes in minutes
  double acceleration = 0;  // mm/s2
  // Noise of a camera.
  double pixel = 0;  // standard deviation of each value of a pixel, 0 to 255
};

// The picture and the lens of a camera: a pinhole with radial distortion, as OpenCV's camera matrix
// and distortion coefficients. The principal point is the middle of the picture.
struct CameraDescription {
  int width = 640;  // pixels
  int height = 480;
  double focal = 554;  // pixels
  double k1 = 0;       // a point at tan(angle) r of the axis appears at r (1 + k1 r^2 + k2 r^4)
  double k2 = 0;
  int quality = 80;  // of JPEG, 1 to 100
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
  tims::Duration from{};  // since the start of the world
  tims::Duration to{};
};

// The axis of the robot that a scanner is turned about, through the scanner's position.
enum class TurnedAbout : std::uint8_t { kNothing, kRoll, kPitch, kYaw };

struct AxisDescription {
  TurnedAbout about = TurnedAbout::kNothing;  // roll: x, pitch: y, yaw: z of the robot
  double gear_ratio = 1;                      // motor turns per turn of the axis
  // For the emulation of its drive: emulator and line.
  std::string device{};
  std::string line{};
};

struct SensorDescription {
  std::string name{};
  SensorKind kind = SensorKind::kScanner;
  // Pose relative to the robot's reference point. phi: rolled to the right, psi: looking up.
  Pose mount{};
  AxisDescription axis{};    // at angle 0 the sensor has the pose of its mount
  double max_range = 80000;  // of rays
  NoiseDescription noise{};
  tims::Duration lag{};           // from measurement to telegram; only stored here
  std::vector<Outage> outages{};  // of satellites: times without a fix
  tims::Duration period{};        // between fixes of a satellite receiver; 0: the device's default
                                  // of a camera: between pictures
  CameraDescription camera{};     // of cameras
  // For the emulation of the device: emulator and address of its line. Not used here.
  std::string device{};
  std::string line{};
};

struct RobotDescription {
  std::string name{};
  DriveKind kind = DriveKind::kDifferential;
  Pose start{};
  // Geometry of the wheels. The reference point is midway between two driven wheels, on the rear
  // axle, or midway between two steered axles (components/geometry/wheels.h).
  double track = 400;
  double base = 1200;
  double steer_max = 0.4;  // rad
  // Gears between motors and wheels, for emulated motors that report turns of their shafts.
  double wheel_radius = 110;
  double gear_ratio = 1;   // motor turns per turn of the wheel
  double steer_ratio = 1;  // motor turns per turn of the steering
  // Its hull, from the reference point.
  double front = 250;
  double back = 250;
  double left = 250;
  double right = 250;
  double height = 600;
  // Limits of its motors; 0: no limit.
  double acceleration = 0;   // mm/s2, of each rim
  double deceleration = 0;   // mm/s2; 0: as acceleration
  double steering_rate = 0;  // rad/s
  tims::Duration lag{};      // from a command to the reaction of the motors
  SlipDescription slip{};
  // For the emulation of the base: emulator and line, as for sensors.
  std::string device{};
  std::string line{};
  std::vector<SensorDescription> sensors{};
};

// --- the whole world

// The place on Earth of x = 0, y = 0. The world is a plane in the UTM zone of that place: x is its
// north, y its east. Position shows the same coordinates with the reference UTM, this zone and
// band, and this northing and easting as its offset.
struct Origin {
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double altitude = 0;   // m
};

struct WorldDescription {
  std::string name{};
  std::uint64_t seed = 1;
  Area ground{{-50000, -50000}, {50000, 50000}};  // nothing moves outside of it
  Origin origin{};
  double ceiling = 0;  // mm above the ground, only visible to cameras; 0: under the sky
  std::vector<WallDescription> walls{};
  std::vector<ObstacleDescription> obstacles{};
  std::vector<vision::Marker> markers{};  // only cameras see them
  PeopleDescription people{};
  std::vector<RobotDescription> robots{};
};

}  // namespace rack::world
