// What sensors see, against what can be computed by hand.
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "components/geometry/coordinates.h"
#include "components/world/core/rooms_fixture.h"
#include "components/world/core/view.h"
#include "components/world/core/world.h"

namespace rack::world {
namespace sensing_test {

constexpr double kGravity = 9806.65;

WorldDescription field(const SensorDescription& sensor) {
  WorldDescription description;
  description.origin = {radians(37.54), radians(-122.06), 20};
  description.robots = {room_robot()};
  description.robots[0].start = {};
  description.robots[0].sensors = {sensor};
  return description;
}

TEST(Sensing, RaysAreThoseOfFloorMap) {
  WorldDescription description = rooms_world();
  description.obstacles.clear();
  DxfDrawing drawing;
  for (const WallDescription& wall : description.walls)
    drawing.lines.push_back({{wall.from.y, wall.from.x}, {wall.to.y, wall.to.x}});
  description.robots[0].start.rho = 0.7;
  description.robots[0].sensors[0].mount.rho = 0.2;
  const World world = made(description);
  const Pose from = world.sensor_pose({0, 0}, kBegin);
  std::vector<double> ranges(361);
  FloorMap(drawing, 1, 0, 0).cast({{from.x, from.y}, from.rho - kPi, radians(1)}, 30000, ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const RayHit hit =
        world.look({0, 0}, {.azimuth = radians(static_cast<double>(i)) - kPi}, kBegin);
    EXPECT_NEAR(hit.range, ranges[i], 0.01) << i;
    EXPECT_EQ(hit.met, Met::kWall);
  }
}

// A robot that turns on the spot: a ray at its own time looks where the robot looked then.
TEST(Sensing, AMirrorSeesEachRayAtItsOwnTime) {
  WorldDescription description = rooms_world();
  description.robots[0].sensors[0].mount = {.z = -300};
  World world = made(description);
  world.drive(0, std::array{200.0, -200.0}, kBegin);  // 1 rad/s
  world.advance(kBegin + seconds(0.5));
  for (const double at : {0.0, 0.1003, 0.25, 0.3331, 0.5}) {
    EXPECT_NEAR(world.pose(0, kBegin + seconds(at)).rho, at, 1e-6);
    const double ahead = world.look({0, 0}, {.azimuth = 0.1}, kBegin + seconds(at)).range;
    EXPECT_NEAR(ahead, std::min(3000 / std::cos(at + 0.1), 2500 / std::sin(at + 0.1)), 0.01) << at;
  }
  EXPECT_NEAR(world.pose(0, kBegin + seconds(7)).rho, 0.5, 1e-6) << "later is now";
  EXPECT_NEAR(world.pose(0, kBegin - seconds(7)).rho, 0, 1e-6);
}

TEST(Sensing, SeesTheGroundAndLooksOverWhatIsLow) {
  WorldDescription description =
      field({.kind = SensorKind::kScanner3d, .mount = {.z = -1000}, .max_range = 20000});
  description.obstacles = {{.at = {4000, 0}, .length = 1000, .width = 2000, .height = 500}};
  description.walls = {{.from = {8000, -9000}, .to = {8000, 9000}, .height = 2000}};
  const World world = made(description);
  const auto look = [&](double elevation, double azimuth = 0) {
    return world.look({0, 0}, {.azimuth = azimuth, .elevation = elevation}, kBegin);
  };
  EXPECT_EQ(look(0).met, Met::kWall);
  EXPECT_NEAR(look(0).range, 8000, 1e-6);
  EXPECT_EQ(look(radians(-20)).met, Met::kGround);
  EXPECT_NEAR(look(radians(-20)).range, 1000 / std::sin(radians(20)), 1e-6);
  EXPECT_EQ(look(std::atan(-0.75 / 3.5)).met, Met::kObstacle);
  EXPECT_NEAR(look(std::atan(-0.75 / 3.5)).range, std::hypot(3500, 750), 1e-6) << "its side";
  EXPECT_NEAR(look(std::atan(-0.5 / 4)).range, std::hypot(4000, 500), 1e-6) << "its top";
  EXPECT_EQ(look(std::atan(1.1 / 8)).met, Met::kNothing) << "over the wall";
  EXPECT_EQ(look(std::atan(0.9 / 8)).met, Met::kWall);
  EXPECT_EQ(look(radians(-90)).met, Met::kGround);
  EXPECT_NEAR(look(radians(-90)).range, 1000, 1e-6);
  EXPECT_EQ(look(radians(90)).met, Met::kNothing);
  EXPECT_EQ(look(radians(90)).range, 20000);
  EXPECT_EQ(look(radians(-1), kPi).met, Met::kNothing) << "further than it sees";
}

// Each ray at the axis' own angle of its time.
TEST(Sensing, AnAxisTurnsAScannerWhileItsMirrorGoesRound) {
  SensorDescription tilting{.kind = SensorKind::kScanner,
                            .mount = {.x = 200, .z = -1000, .rho = radians(20)},
                            .axis = {.about = TurnedAbout::kPitch}};
  World world = made(field(tilting));
  const double nan = std::nan("");
  world.turn({0, 0}, radians(-20));
  world.turn({0, 0}, nan);
  world.advance(kBegin + seconds(0.5));
  for (const double at : {0.1, 0.2002, 0.3331, 0.5}) {
    const tims::Time when = kBegin + seconds(at);
    const double down = radians(20) * at;
    EXPECT_NEAR(world.axis({0, 0}, when), -down, 1e-9);
    const RayHit ahead = world.look({0, 0}, {.azimuth = radians(-20)}, when);
    EXPECT_NEAR(ahead.range, 1000 / std::sin(down), 1e-3) << "about the robot's own axis";
    EXPECT_EQ(world.look({0, 0}, {.azimuth = radians(70)}, when).met, Met::kNothing);
  }
  EXPECT_EQ(world.axis({0, 0}, kBegin), 0);

  // Upright on a turntable: what is to the right of the scanner is below.
  SensorDescription upright{.kind = SensorKind::kScanner,
                            .mount = {.z = -1000, .phi = kPi / 2},
                            .axis = {.about = TurnedAbout::kYaw}};
  WorldDescription room = rooms_world();
  room.obstacles.clear();
  room.robots[0].sensors = {upright};
  World turning = made(room);
  turning.turn({0, 0}, 1);
  turning.advance(kBegin + seconds(1.2));
  for (const double at : {0.3, 0.7003, 1.2}) {
    const tims::Time when = kBegin + seconds(at);
    EXPECT_NEAR(turning.look({0, 0}, {}, when).range,
                std::min(3000 / std::cos(at), 2500 / std::sin(at)), 0.01);
    EXPECT_NEAR(turning.look({0, 0}, {.azimuth = kPi / 2}, when).range, 1000, 1e-6);
  }

  // Rolled: half a right angle, and what was to the right is on the ground.
  upright = {
      .kind = SensorKind::kScanner, .mount = {.z = -1000}, .axis = {.about = TurnedAbout::kRoll}};
  World rolling = made(field(upright));
  rolling.turn({0, 0}, kPi / 4);
  rolling.advance(kBegin + seconds(1));
  EXPECT_NEAR(rolling.look({0, 0}, {.azimuth = kPi / 2}, rolling.now()).range, 1000 * std::sqrt(2),
              1e-6);
}

TEST(Sensing, AMountTilts) {
  SensorDescription down{.kind = SensorKind::kScanner, .mount = {.z = -1000, .psi = radians(-10)}};
  EXPECT_NEAR(made(field(down)).look({0, 0}, {}, kBegin).range, 1000 / std::sin(radians(10)), 1e-6);
  EXPECT_EQ(made(field(down)).look({0, 0}, {.azimuth = kPi}, kBegin).met, Met::kNothing);
  // Rolled to the right, the ray to the right meets the ground.
  SensorDescription rolled{.kind = SensorKind::kScanner,
                           .mount = {.z = -1000, .phi = radians(10), .rho = 0}};
  EXPECT_NEAR(made(field(rolled)).look({0, 0}, {.azimuth = kPi / 2}, kBegin).range,
              1000 / std::sin(radians(10)), 1e-6);
  EXPECT_EQ(made(field(rolled)).look({0, 0}, {.azimuth = -kPi / 2}, kBegin).met, Met::kNothing);
}

TEST(Sensing, SeesOthersAndNotItself) {
  WorldDescription description = rooms_world(1);
  description.robots.push_back(room_robot());
  description.robots[1].start = {.x = 5000, .y = 2500};
  World world = made(description);
  world.freeze_people(true);
  const RayHit hit = world.look({0, 0}, {}, kBegin);
  const PersonTruth person = world.make_truth().people[0];
  const Pose from = world.sensor_pose({0, 0}, kBegin);
  const bool is_between = std::hypot(person.at.x - 4000, person.at.y - 2500) < 1200;
  if (!is_between) {
    EXPECT_EQ(hit.met, Met::kRobot);
    EXPECT_EQ(hit.id, 1U);
    EXPECT_NEAR(hit.range, 1650, 1e-6);
  }
  // Straight at the person, from wherever there is nothing between.
  ASSERT_TRUE(world.place(0, {.x = person.at.x, .y = person.at.y - 700}) ||
              world.place(0, {.x = person.at.x, .y = person.at.y + 700}));
  const Pose now = world.sensor_pose({0, 0}, kBegin);
  int hits = 0;
  for (double beside = -150; beside <= 150; beside += 10) {
    const double angle =
        std::atan2(person.at.y - now.y, person.at.x - now.x) + std::atan(beside / 700);
    const RayHit at_person = world.look({0, 0}, {.azimuth = angle - now.rho}, kBegin);
    hits += at_person.met == Met::kPerson && at_person.id == 0 ? 1 : 0;
  }
  EXPECT_GT(hits, 8) << "legs, from " << from.x;
  EXPECT_LT(hits, 31) << "and what is between them";
}

TEST(Sensing, MeasuresWithTheConfiguredNoise) {
  WorldDescription description = rooms_world();
  description.robots[0].sensors[0].noise = {.range = 20, .short_share = 0.05, .dropped_share = 0.1};
  World world = made(description);
  world.advance(kBegin + seconds(1));
  int dropped = 0;
  int cut = 0;
  double square = 0;
  constexpr int kRays = 40000;
  for (int i = 0; i < kRays; ++i) {
    const tims::Time at = kBegin + i * std::chrono::microseconds(20);
    const Echo echo = world.measure({0, 0}, {}, at);
    EXPECT_NEAR(echo.truth.range, 2900, 1e-6);
    const double error = echo.range - echo.truth.range;
    if (!echo.is_valid) {
      ++dropped;
    } else if (error < -75) {
      ++cut;
    } else {
      square += error * error;
    }
    EXPECT_LT(error, 75);
    ASSERT_EQ(echo.range, world.measure({0, 0}, {}, at).range);
  }
  EXPECT_NEAR(dropped, 0.1 * kRays, 0.01 * kRays);
  EXPECT_NEAR(cut, 0.05 * kRays, 0.01 * kRays);
  EXPECT_NEAR(std::sqrt(square / (kRays - dropped - cut)), 20, 0.7);
}

// A receiver's fix, through the projection that Position uses, is where the antenna is.
TEST(Sensing, FixesAreTheTruthOnTheGrid) {
  WorldDescription description = field({.kind = SensorKind::kSatellite, .mount = {.x = 400}});
  description.robots[0].start = {.x = 10000, .y = -20000, .rho = kPi / 2};
  World world = made(description);
  world.drive(0, std::array{500.0, 500.0}, kBegin);
  world.advance(kBegin + seconds(2));
  const SatelliteFix fix = world.satellite_fix({0, 0}, world.now());
  ASSERT_TRUE(fix.is_valid);
  const auto utm = [](double latitude, double longitude) {
    return navigation::to_utm({.latitude = latitude, .longitude = longitude}).value();
  };
  const auto here = utm(fix.latitude, fix.longitude);
  const auto origin = utm(description.origin.latitude, description.origin.longitude);
  EXPECT_NEAR(static_cast<double>(here.northing - origin.northing), 10000, 2);
  EXPECT_NEAR(static_cast<double>(here.easting - origin.easting), -20000 + 400 + 1000, 2);
  EXPECT_NEAR(fix.course, kPi / 2, 1e-6);
  EXPECT_NEAR(fix.speed, 500, 1e-3);
  EXPECT_EQ(fix.altitude, 20);
}

TEST(Sensing, FixesDriftAndFail) {
  SensorDescription receiver{.kind = SensorKind::kSatellite};
  receiver.noise = {.position = 1000, .drift = 2000};
  receiver.outages = {{seconds(10), seconds(20)}};
  World world = made(field(receiver));
  double square = 0;
  double jump = 0;
  double last = 0;
  constexpr int kFixes = 4000;
  for (int i = 0; i < kFixes; ++i) {
    world.advance(kBegin + i * seconds(0.5));
    const SatelliteFix fix = world.satellite_fix({0, 0}, world.now());
    ASSERT_EQ(fix.is_valid, i < 20 || i >= 40) << i;
    if (!fix.is_valid) continue;
    const double north = (fix.latitude - radians(37.54)) * 6.36e9;  // mm
    square += north * north / kFixes;
    if (i != 40 && i != 0) jump += (north - last) * (north - last) / kFixes;
    last = north;
  }
  EXPECT_NEAR(std::sqrt(square), std::hypot(1000, 2000), 700);
  EXPECT_NEAR(std::sqrt(jump), std::sqrt(2.0) * 1000, 150) << "from fix to fix only the noise";
}

TEST(Sensing, InertialSensorsFeelACircle) {
  SensorDescription imu{.kind = SensorKind::kInertial, .mount = {.x = 300, .phi = radians(90)}};
  World world = made(field(imu));
  world.drive(0, std::array{600.0, 400.0}, kBegin);  // 500 mm/s, 0.5 rad/s
  world.advance(kBegin + seconds(3));
  const InertialMeasurement turned = world.inertial({0, 0}, world.now());
  // Rolled to the right by 90 degrees: its y looks down, its z to the left.
  EXPECT_NEAR(turned.rates[1], 0.5, 1e-6);
  EXPECT_NEAR(turned.rates[2], 0, 1e-6);
  EXPECT_NEAR(turned.accelerations[0], -0.25 * 300, 1e-2);
  EXPECT_NEAR(turned.accelerations[1], -kGravity, 1e-2);
  EXPECT_NEAR(turned.accelerations[2], -250, 1e-2);
  EXPECT_NEAR(turned.phi, radians(90), 1e-9);
  EXPECT_NEAR(turned.rho, 1.5, 1e-4);
}

TEST(Sensing, InertialSensorsFeelBraking) {
  WorldDescription description = field({.kind = SensorKind::kInertial});
  description.robots[0].acceleration = 1000;
  World world = made(description);
  world.drive(0, std::array{800.0, 800.0}, kBegin);
  world.advance(kBegin + seconds(0.4));
  EXPECT_NEAR(world.inertial({0, 0}, world.now()).accelerations[0], 1000, 1e-2);
  EXPECT_NEAR(world.inertial({0, 0}, world.now()).accelerations[2], -kGravity, 1e-6);
  world.advance(kBegin + seconds(2));
  EXPECT_NEAR(world.inertial({0, 0}, world.now()).accelerations[0], 0, 1e-2);
}

TEST(Sensing, ACompassPointsNorth) {
  SensorDescription compass{.kind = SensorKind::kCompass, .mount = {.rho = 0.5}};
  WorldDescription description = field(compass);
  description.robots[0].start.rho = 6;
  EXPECT_NEAR(made(description).compass({0, 0}, kBegin), 6.5 - 2 * kPi, 1e-9);
  description.robots[0].sensors[0].noise.angle = 0.1;
  EXPECT_NE(made(description).compass({0, 0}, kBegin), 6.5 - 2 * kPi);
}

// A camera gets the moment that it asks for, in its own directions.
TEST(Sensing, AViewIsThatOfItsTime) {
  WorldDescription description = field({.name = "camera",
                                        .kind = SensorKind::kCamera,
                                        .mount = {.x = 300, .z = -500, .psi = 0.2, .rho = 0.1}});
  description.robots.push_back({.name = "other", .start = {.x = 3000}, .front = 100, .back = 100});
  description.people.walks = {{.places = {{8000, -3000}, {8000, 3000}}, .pause = {}}};
  World world = made(description);
  const std::array speeds = {500.0, 400.0};
  world.drive(0, speeds, kBegin);
  world.advance(kBegin + seconds(2));
  ASSERT_TRUE(world.put({.shape = Shape::kCircle, .at = {5000, 5000}}));
  world.advance(kBegin + seconds(2.5));

  View then;
  View now;
  world.view({0, 0}, kBegin + seconds(1.9), then);
  world.view({0, 0}, kBegin + seconds(2.5), now);
  EXPECT_EQ(then.age, seconds(1.9));
  const Pose pose = world.sensor_pose({0, 0}, kBegin + seconds(1.9));
  EXPECT_NEAR(then.from[0], pose.x, 1e-9);
  EXPECT_NEAR(then.from[1], pose.y, 1e-9);
  EXPECT_EQ(then.from[2], -500);
  // Its x axis: turned as the robot and its mount, and upwards.
  EXPECT_NEAR(std::atan2(then.turn[1][0], then.turn[0][0]), signed_angle(pose.rho), 1e-9);
  EXPECT_NEAR(-then.turn[2][0], std::sin(0.2), 1e-9);
  EXPECT_GT(std::hypot(now.from[0] - then.from[0], now.from[1] - then.from[1]), 200);
  ASSERT_EQ(now.robots.size(), 1U);
  EXPECT_EQ(now.robots[0].id, 1U) << "not itself";
  EXPECT_NEAR(now.robots[0].hull.at.x, 3000, 1e-9);
  ASSERT_EQ(now.people.size(), 1U);
  EXPECT_NE(now.people[0].at.y, then.people[0].at.y);
  EXPECT_TRUE(then.obstacles.empty()) << "not yet there";
  EXPECT_EQ(now.obstacles.size(), 1U);
}

}  // namespace sensing_test
}  // namespace rack::world
