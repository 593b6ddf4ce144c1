#include "components/pilot/wall_follower.h"

#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "components/navigation/dead_reckoning.h"
#include "components/sim/chassis_model.h"
#include "components/sim/scan_model.h"

namespace rack::pilot {
namespace {

using namespace std::chrono_literals;
using Mode = WallFollowerSettings::Mode;

constexpr double kCorner = 354;  // of a hull 250 mm to each side

ChassisParamData chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 700;
  chassis.vxMin = 50;
  chassis.omegaMax = static_cast<f32>(radians(20));
  chassis.breakConstant = 1;
  chassis.safetyMargin = 50;
  chassis.safetyMarginMove = 200;
  chassis.boundaryFront = chassis.boundaryBack = 250;
  chassis.boundaryLeft = chassis.boundaryRight = 250;
  return chassis;
}

FloorMap floor() {
  std::ifstream file(FLOOR_PLAN);
  const auto drawing = read_dxf(std::string(std::istreambuf_iterator<char>(file), {}));
  EXPECT_TRUE(drawing.ok());
  return {*drawing, 1000, 0, 0};
}

// Robot, floor and pilot, without a computer's clock.
class Trip {
 public:
  Trip(Mode mode, i32 speed)
      : follower_({.mode = mode, .speed_max = speed, .omega_max = radians(20)}, chassis()) {}

  void drive(std::chrono::minutes time) {
    for (auto t = 0ms; t < time; t += 100ms) step();
  }

  double way = 0;          // mm
  double clearance = 1e9;  // mm, the smallest
  Pose min{.x = 1e9, .y = 1e9};
  Pose max{.x = -1e9, .y = -1e9};

 private:
  void step() {
    Scan2dData scan;
    eyes_.see(at_, 100ms, scan);
    const Drive drive = follower_.follow(scan, 100ms);
    wheels_.move({.vx = drive.speed, .omega = drive.omega});
    const ChassisData moved = wheels_.step(0, 100ms);
    at_ = reckoning_.add(moved);
    way += moved.deltaX;
    const double x = at_.pos.x;
    const double y = at_.pos.y;
    clearance = std::min(clearance, map_.clearance({x, y}));
    min = {.x = std::min(min.x, x), .y = std::min(min.y, y)};
    max = {.x = std::max(max.x, x), .y = std::max(max.y, y)};
  }

  FloorMap map_ = floor();
  sim::ScanModel eyes_{floor(), {}};
  sim::ChassisModel wheels_{chassis(), false};
  navigation::DeadReckoning reckoning_{{}};
  OdometryData at_;
  WallFollower follower_;
};

TEST(WallFollower, FollowsWallsForEver) {
  for (const i32 speed : {200, 500, 1000}) {
    Trip trip(Mode::kGeometric, speed);
    trip.drive(60min);
    EXPECT_GT(trip.clearance, kCorner) << speed;
    EXPECT_GT(trip.way, 3600.0 * std::min(speed, 700) * 0.4) << speed;
    // All the way round the rooms, from one side of the floor to the other.
    EXPECT_LT(trip.min.x, 500);
    EXPECT_LT(trip.min.y, 500);
    EXPECT_GT(trip.max.x, 6500);
    EXPECT_GT(trip.max.y, 8500);
  }
}

TEST(WallFollower, WandersForEver) {
  for (const i32 speed : {200, 500, 1000}) {
    Trip trip(Mode::kBraitenberg, speed);
    trip.drive(60min);
    EXPECT_GT(trip.clearance, kCorner) << speed;
    EXPECT_GT(trip.way, 3600.0 * std::min(speed, 700) * 0.3) << speed;
  }
}

Scan2dData point(i32 x, i32 y, i32 type = 0) {
  Scan2dData scan;
  scan.points = {{.x = x, .y = y, .type = type}};
  return scan;
}

TEST(WallFollower, TurnsRightWhereItCannotGoOn) {
  WallFollower follower({}, chassis());
  const Drive drive = follower.follow(point(400, 0), 100ms);
  EXPECT_EQ(drive.speed, 0);
  EXPECT_EQ(drive.speed_max, 0);
  EXPECT_NEAR(drive.omega, radians(20), 1e-6);
  EXPECT_EQ(follower.follow(point(900, 0), 100ms).speed, 0) << "not much room yet";
  EXPECT_GT(follower.follow(point(2000, 0), 100ms).speed, 0);
}

TEST(WallFollower, BecomesFasterBitByBit) {
  WallFollower follower({}, chassis());
  EXPECT_EQ(follower.follow({}, 100ms).speed, 20);
  EXPECT_EQ(follower.follow({}, 100ms).speed, 40);
  for (int i = 0; i < 100; ++i) (void)follower.follow({}, 100ms);
  EXPECT_EQ(follower.follow({}, 100ms).speed, 500);
}

TEST(WallFollower, SteersByWhatItSees) {
  WallFollower away({.mode = Mode::kBraitenberg}, chassis());
  EXPECT_GT(away.follow(point(500, -600), 100ms).omega, 0);
  EXPECT_LT(away.follow(point(500, 600), 100ms).omega, 0);
  EXPECT_EQ(away.follow(point(500, 600, scan_point::kInvalid), 100ms).omega, 0);
  WallFollower along({.mode = Mode::kGeometric}, chassis());
  EXPECT_NEAR(along.follow(point(0, -1000), 100ms).omega, 0, 1e-6);
  EXPECT_GT(along.follow(point(0, -900), 100ms).omega, 0) << "too near";
  EXPECT_LT(along.follow(point(0, -1200), 100ms).omega, 0) << "too far";
}

}  // namespace
}  // namespace rack::pilot
