#include "components/world/core/vehicle.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rack::world {
namespace vehicle_test {

constexpr tims::Time kBegin{std::chrono::seconds(100)};
constexpr double kSeconds = std::chrono::duration<double>(kStep).count();

// Drives it for a while from the begin.
Pose driven(Vehicle& vehicle, int steps, int first = 0) {
  Pose pose;
  for (int i = first; i < first + steps; ++i) pose = moved(pose, vehicle.step(kBegin + i * kStep));
  return pose;
}

TEST(Vehicle, TwoWheelsDriveACircle) {
  Vehicle vehicle({.track = 400}, 1);
  // 500 mm/s on a radius of 1 m: 2 pi in 12.566 s.
  vehicle.drive(std::array{600.0, 400.0}, kBegin);
  const Pose pose = driven(vehicle, 2513);
  EXPECT_NEAR(std::hypot(pose.x, pose.y), 0, 2);
  EXPECT_NEAR(vehicle.motors()[0].position, 600 * 2513 * kSeconds, 1e-6);
  EXPECT_NEAR(vehicle.motors()[1].position, 400 * 2513 * kSeconds, 1e-6);
}

TEST(Vehicle, ACarDrivesTheCircleOfItsSteering) {
  Vehicle vehicle({.kind = DriveKind::kAckermann, .track = 800, .base = 1200, .steer_max = 0.5}, 1);
  vehicle.drive(device::ChassisSpeed{.vx = 1000, .omega = 0.25F}, kBegin);
  EXPECT_NEAR(driven(vehicle, 400).rho, 0.5, 1e-4);
  EXPECT_NEAR(vehicle.motors()[2].position, std::atan(1200 * 0.25 / 1000), 1e-6);
  vehicle.drive(std::array{0.0, 0.0, 0.3}, kBegin);
  EXPECT_EQ(driven(vehicle, 100, 400).rho, 0);
}

TEST(Vehicle, BothAxlesSteerAlikeToGoAside) {
  Vehicle vehicle({.kind = DriveKind::kDoubleAckermann, .steer_max = 0.4}, 1);
  vehicle.drive(std::array{100.0, 100.0, 100.0, 100.0, 0.3, 0.3}, kBegin);
  const Pose pose = driven(vehicle, 200);
  EXPECT_NEAR(pose.x, 100 * std::cos(0.3), 1e-3);
  EXPECT_NEAR(pose.y, 100 * std::sin(0.3), 1e-3);
  EXPECT_NEAR(pose.rho, 0, 1e-9);
}

TEST(Vehicle, CommandsComeAfterTheLagAndMotorsFollowAsTheyCan) {
  Vehicle vehicle({.acceleration = 1000, .deceleration = 2000}, 1);
  // The lag is part of the time that it is due.
  vehicle.drive(std::array{500.0, 500.0}, kBegin + 10 * kStep);
  EXPECT_EQ(driven(vehicle, 10).x, 0);
  driven(vehicle, 50, 10);
  EXPECT_NEAR(vehicle.motors()[0].speed, 250, 1e-9);
  driven(vehicle, 60, 60);
  EXPECT_EQ(vehicle.motors()[0].speed, 500);
  vehicle.drive(std::array{0.0, 0.0}, kBegin);  // late: from now on
  driven(vehicle, 25, 120);
  EXPECT_NEAR(vehicle.motors()[0].speed, 250, 1e-9);
  driven(vehicle, 26, 145);
  EXPECT_EQ(vehicle.motors()[0].speed, 0);
}

TEST(Vehicle, SteeringTakesItsTime) {
  Vehicle vehicle({.kind = DriveKind::kAckermann, .steer_max = 0.3, .steering_rate = 0.5}, 1);
  vehicle.drive(std::array{0.0, 0.0, 5.0}, kBegin);
  driven(vehicle, 60);
  EXPECT_NEAR(vehicle.motors()[2].position, 0.15, 1e-9);
  EXPECT_NEAR(vehicle.motors()[2].speed, 0.5, 1e-9);
  driven(vehicle, 100, 60);
  EXPECT_EQ(vehicle.motors()[2].position, 0.3);
}

TEST(Vehicle, SlipsAsMuchAsConfigured) {
  RobotDescription robot;
  robot.slip = {.distance = 0.1, .turn = 0.2};
  Vehicle vehicle(robot, 1);
  vehicle.drive(std::array{1000.0, 1000.0}, kBegin);
  EXPECT_NEAR(driven(vehicle, 200).x, 900, 1e-3);
  vehicle.drive(std::array{200.0, -200.0}, kBegin);  // 1 rad/s
  EXPECT_NEAR(driven(vehicle, 200, 200).rho, 0.8, 1e-4);
  EXPECT_NEAR(vehicle.motors()[0].position, 1200, 1e-6);
}

TEST(Vehicle, NoiseGrowsWithTheRootOfTheDistance) {
  RobotDescription robot;
  robot.slip = {.distance_noise = 20, .turn_noise = 0.01};
  double variance = 0;
  double turn = 0;
  constexpr int kRuns = 400;
  for (int i = 0; i < kRuns; ++i) {
    Vehicle vehicle(robot, static_cast<std::uint64_t>(i));
    vehicle.drive(std::array{1000.0, 1000.0}, kBegin);
    double x = 0;
    double rho = 0;
    for (int step = 0; step < 800; ++step) {
      const Movement m = vehicle.step(kBegin + step * kStep);
      x += m.x;
      rho += m.rho;
    }
    variance += (x - 4000) * (x - 4000) / kRuns;
    turn += rho * rho / kRuns;
  }
  EXPECT_NEAR(std::sqrt(variance), 40, 5);
  EXPECT_NEAR(std::sqrt(turn), 0.02, 0.0025);
}

TEST(Vehicle, TakesNoNonsense) {
  Vehicle vehicle({}, 1);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  vehicle.drive(std::array{100.0, kNan, 3.0, 4.0, 5.0, 6.0, 7.0}, kBegin);
  vehicle.drive(device::ChassisSpeed{.vx = std::numeric_limits<float>::infinity()}, kBegin);
  driven(vehicle, 1);
  EXPECT_EQ(vehicle.motors()[0].speed, 100);
  EXPECT_EQ(vehicle.motors()[1].speed, 0);
  for (int i = 0; i < 2000; ++i)  // more than there is room for: the newest counts
    vehicle.drive(std::array{1.0 * i, 0.0}, kBegin + std::chrono::milliseconds(i));
  driven(vehicle, 1000);
  EXPECT_EQ(vehicle.motors()[0].speed, 1999);
}

}  // namespace vehicle_test
}  // namespace rack::world
