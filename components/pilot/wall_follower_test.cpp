#include "components/pilot/wall_follower.h"

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>

#include <gtest/gtest.h>

#include "components/position/reckoning.h"
#include "components/world/core/models.h"
#include "tests/support/patience.h"

namespace rack::pilot {
namespace wall_follower_test {

using namespace std::chrono_literals;
using Mode = WallFollowerSettings::Mode;

constexpr double kCorner = 354;  // of a hull 250 mm to each side

ChassisParamData chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 700;
  chassis.vxMin = 50;
  chassis.omegaMax = static_cast<f32>(radians(20));
  chassis.minTurningRadius = 200;
  chassis.pilotParameterA = 0.001F;
  chassis.pilotParameterB = 2;
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
      : Trip({.mode = mode, .speed_max = speed, .omega_max = radians(20)}, floor()) {}
  Trip(const WallFollowerSettings& settings, const FloorMap& map)
      : map_(map), eyes_(map, {}), follower_(settings, chassis()) {}

  void drive(std::chrono::minutes time) {
    for (auto t = 0ms; t < time; t += 100ms) step();
  }

  double travelled = 0;    // mm
  double clearance = 1e9;  // mm, the smallest
  Pose min{.x = 1e9, .y = 1e9};
  Pose max{.x = -1e9, .y = -1e9};

 private:
  void step() {
    Scan2dData scan;
    eyes_.measure(at_, 100ms, scan);
    const Drive drive = follower_.follow(scan, 100ms, at_.pos.rho);
    wheels_.move({.vx = drive.speed, .omega = drive.omega});
    const ChassisData moved = wheels_.step(0, 100ms);
    at_ = reckoning_.add(moved);
    travelled += moved.deltaX;
    const double x = at_.pos.x;
    const double y = at_.pos.y;
    clearance = std::min(clearance, map_.clearance({x, y}));
    min = {.x = std::min(min.x, x), .y = std::min(min.y, y)};
    max = {.x = std::max(max.x, x), .y = std::max(max.y, y)};
  }

  FloorMap map_;
  sim::ScanModel eyes_;
  sim::ChassisModel wheels_{chassis(), false};
  navigation::DeadReckoning reckoning_{{}};
  OdometryData at_;
  WallFollower follower_;
};

// An hour at each; builds with sanitizers drive at the last only.
constexpr std::array<i32, 3> kAllSpeeds = {200, 500, 1000};
constexpr std::span kSpeeds = std::span(kAllSpeeds).last(tims::test::kSlowdown == 1 ? 3 : 1);

TEST(WallFollower, FollowsWallsForEver) {
  for (const i32 speed : kSpeeds) {
    Trip trip(Mode::kGeometric, speed);
    trip.drive(60min);
    EXPECT_GT(trip.clearance, kCorner) << speed;
    EXPECT_GT(trip.travelled, 3600.0 * std::min(speed, 700) * 0.4) << speed;
    // Around all rooms, from one side of the floor to the other.
    EXPECT_LT(trip.min.x, 500);
    EXPECT_LT(trip.min.y, 500);
    EXPECT_GT(trip.max.x, 6500);
    EXPECT_GT(trip.max.y, 8500);
  }
}

TEST(WallFollower, WandersForEver) {
  for (const i32 speed : kSpeeds) {
    Trip trip(Mode::kBraitenberg, speed);
    trip.drive(60min);
    EXPECT_GT(trip.clearance, kCorner) << speed;
    EXPECT_GT(trip.travelled, 3600.0 * std::min(speed, 700) * 0.3) << speed;
  }
}

// Two rooms, and between them a bent corridor that is 1 m wide where it bends, as in the original's
// example map.
FloorMap corridor() {
  DxfDrawing drawing;
  drawing.lines = {{{-1.2, 0.5}, {-0.2, 2.5}},
                   {{-0.2, 2.5}, {-1.2, 4.5}},
                   {{0.8, -1.5}, {0.8, 2.5}},
                   {{0.8, 2.5}, {-0.2, 5.5}}};
  return {drawing, 1000, 0, 0};
}

TEST(WallFollower, PassesANarrowCorridor) {
  Trip trip({.mode = Mode::kGeometric, .speed_max = 500, .distance = 500}, corridor());
  trip.drive(1min);
  EXPECT_GT(trip.max.x, 4500);
  EXPECT_GT(trip.clearance, kCorner);
}

// How far to the south and to the north the original's rules lead in the same world in a minute.
// At 1000 it turns back where the corridor is narrow, and goes round the outside.
TEST(WallFollower, GoesWhereTheOriginalGoes) {
  struct Original {
    Mode mode;
    i32 distance;
    double min_x, max_x;
  };
  for (const Original& original : {Original{Mode::kGeometric, 1000, -587, 5802},
                                   {Mode::kGeometric, 600, -2237, 6217},
                                   {Mode::kGeometric, 500, -2142, 6129},
                                   {Mode::kGeometric, 400, -2050, 6032},
                                   {Mode::kBraitenberg, 1000, -3074, 6937},
                                   {Mode::kBraitenberg, 900, -3064, 6888},
                                   {Mode::kBraitenberg, 500, -3038, 6710}}) {
    Trip trip({.mode = original.mode, .speed_max = 500, .distance = original.distance}, corridor());
    trip.drive(1min);
    EXPECT_NEAR(trip.min.x, original.min_x, 50) << original.distance;
    EXPECT_NEAR(trip.max.x, original.max_x, 250) << original.distance;
  }
}

Scan2dData point(i32 x, i32 y, i32 type = 0) {
  Scan2dData scan;
  scan.points = {{.x = x, .y = y, .z = static_cast<i32>(std::hypot(x, y)), .type = type}};
  return scan;
}

TEST(WallFollower, TurnsAtRestUntilThereIsRoom) {
  WallFollower follower({}, chassis());
  EXPECT_FALSE(follower.turns());
  const Drive stop = follower.follow(point(600, 10), 100ms);
  EXPECT_EQ(stop.speed, 0);
  EXPECT_EQ(stop.omega, 0.0F);
  ASSERT_TRUE(follower.turns()) << "from now on it needs the heading";
  EXPECT_NEAR(follower.follow(point(600, 10), 100ms, 6.2).omega, -radians(20), 1e-6);
  EXPECT_NEAR(follower.follow(point(1700, 0), 100ms, 6.0).omega, -radians(20), 1e-6)
      << "it needs half as much room again";
  EXPECT_EQ(follower.follow(point(1800, 0), 100ms, 5.8).omega, 0.0F);
  EXPECT_FALSE(follower.turns());
  EXPECT_GT(follower.follow(point(1800, 0), 100ms).speed, 0);
}

TEST(WallFollower, TurnsNoFurtherThanItWanted) {
  WallFollower follower({}, chassis());
  (void)follower.follow(point(600, -10), 100ms);
  for (const double heading : {6.0, 6.2, 0.1, 1.0})
    EXPECT_NEAR(follower.follow(point(600, -10), 100ms, heading).omega, radians(20), 1e-6);
  EXPECT_EQ(follower.follow(point(600, -10), 100ms, 6.0 + kPi / 2 - 2 * kPi).omega, 0.0F);
}

TEST(WallFollower, TurnsToTheOtherSideWhereThereIsRoom) {
  WallFollower follower({}, chassis());
  Scan2dData scan = point(510, 10);
  (void)follower.follow(scan, 100ms);
  scan.points.push_back({.x = 100, .y = -260, .z = 279});
  EXPECT_GT(follower.follow(scan, 100ms, 0).omega, 0);
}

TEST(WallFollower, WaitsWithoutRoomToTurn) {
  WallFollower follower({}, chassis());
  Scan2dData scan = point(510, 0);
  (void)follower.follow(scan, 100ms);
  scan.points.push_back({.x = 0, .y = -260, .z = 260});
  scan.points.push_back({.x = 0, .y = 260, .z = 260});
  for (int i = 0; i < 10; ++i) {
    const Drive drive = follower.follow(scan, 100ms, 0);
    EXPECT_EQ(drive.speed, 0);
    EXPECT_EQ(drive.omega, 0.0F);
  }
  (void)follower.follow(point(3000, 0), 100ms, 0);
  EXPECT_GT(follower.follow(point(3000, 0), 100ms, 0).speed, 0) << "somebody took it away";
}

TEST(WallFollower, BecomesFasterBitByBit) {
  WallFollower follower({}, chassis());
  EXPECT_EQ(follower.follow({}, 100ms).speed, 50) << "the smallest there is";
  EXPECT_EQ(follower.follow({}, 100ms).speed, 60);
  EXPECT_EQ(follower.follow({}, 100ms).speed, 70);
  for (int i = 0; i < 100; ++i) (void)follower.follow({}, 100ms);
  EXPECT_EQ(follower.follow({}, 100ms).speed, 500);
}

// By the gains and the turning radius of the chassis.
TEST(WallFollower, KeepsTheWallOnItsRight) {
  const auto omega = [](const Scan2dData& scan) {
    WallFollower along({.mode = Mode::kGeometric}, chassis());
    for (int i = 0; i < 20; ++i) (void)along.follow({}, 100ms);
    return along.follow(scan, 100ms).omega;
  };
  EXPECT_NEAR(omega(point(0, 1000)), 0, 1e-6);
  EXPECT_NEAR(omega(point(0, 900)), -0.2, 1e-3) << "too near";
  EXPECT_NEAR(omega(point(0, 1050)), 0.1, 1e-3) << "too far";
  EXPECT_NEAR(omega(point(100, 995)), -0.2, 0.01) << "towards it";
  EXPECT_EQ(omega(point(0, 900, scan_point::kInvalid)), 0);
  EXPECT_NEAR(omega(point(0, 3000)), radians(20), 2e-3) << "as fast as the chassis can turn";
  WallFollower tight({.mode = Mode::kGeometric}, chassis());
  (void)tight.follow({}, 100ms);
  const Drive drive = tight.follow(point(0, 3000), 100ms);
  EXPECT_NEAR(drive.omega * 200, drive.speed, 1) << "the smallest turning radius";
}

TEST(WallFollower, PutsAWallOfTheLeftToItsRight) {
  WallFollower along({.mode = Mode::kGeometric}, chassis());
  EXPECT_EQ(along.follow(point(-10, -1000), 100ms).speed, 0);
  ASSERT_TRUE(along.turns());
  EXPECT_GT(along.follow(point(-10, -1000), 100ms, 0).omega, 0);
  EXPECT_GT(along.follow(point(0, 1000), 100ms, 3.1).omega, 0);
  EXPECT_EQ(along.follow(point(0, 1000), 100ms, 3.14).omega, 0.0F);
}

TEST(WallFollower, FollowsTheNearerWall) {
  const auto omega = [](const Scan2dData& scan) {
    WallFollower along({}, chassis());
    for (int i = 0; i < 20; ++i) (void)along.follow({}, 100ms);
    return along.follow(scan, 100ms).omega;
  };
  EXPECT_NEAR(omega(point(0, 900)), -0.2, 1e-3);
  EXPECT_NEAR(omega(point(0, -900)), 0.2, 1e-3);
  Scan2dData both = point(0, 900);
  both.points.push_back({.x = 0, .y = -700, .z = 700});
  EXPECT_NEAR(omega(both), 0.2, 1e-3) << "amid both";
}

}  // namespace wall_follower_test
}  // namespace rack::pilot
