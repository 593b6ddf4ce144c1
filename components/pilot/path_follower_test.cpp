#include "components/pilot/path_follower.h"

#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "components/path/route_fixture.h"
#include "components/pilot/car_fixture.h"

namespace rack::pilot {
namespace path_follower_test {

using namespace std::chrono_literals;
using State = PathFollower::State;
using Path = std::vector<PolarSpline>;

Waypoint2d waypoint(i32 x, i32 y, i32 speed = 1, i32 lbo = 2000) {
  Waypoint2d point;
  point.x = x;
  point.y = y;
  point.speed = speed;
  point.lbo = lbo;
  return point;
}

path::PathLimits limits_of(const ChassisParamData& chassis, double speed_max) {
  return {.speed_max = speed_max,
          .acceleration = 0.7 * chassis.accMax,
          .deceleration = 0.7 * chassis.decMax,
          .omega_max = 0.9 * chassis.omegaMax,
          .lateral_acceleration = 1500,
          .radius_min = chassis.minTurningRadius * 1.15,
          .half_width = static_cast<double>(chassis.boundaryLeft)};
}

// A car, a path and its follower, without a computer's clock.
class Drive {
 public:
  Drive(const CarModel& model, Path path, unsigned seed = 1)
      : follower(
            {.chassis = model.chassis, .speed_max = 1e6, .steering_rate = model.steering_rate}),
        path_(std::move(path)),
        car(model, path::pose_at(path_[0], 0), seed) {
    follower.take(path_, car.truth());
  }

  void period(double safe = 1e9) {
    const auto command = follower.follow(car.measured(), car.speed(), safe);
    for (double t = 0; t < 0.0499; t += Car::kStep) {
      car.step(command);
      measure();
    }
    ++periods;
  }
  void run(int periods_max = 20000) {
    while (periods < periods_max && follower.state() == State::kRunning) period();
  }
  [[nodiscard]] double percentile(double part) {
    std::sort(lateral.begin(), lateral.end());
    return lateral[static_cast<std::size_t>(part * static_cast<double>(lateral.size() - 1))];
  }

  PathFollower follower;
  std::vector<double> lateral;  // mm
  double too_fast = 0;          // mm/s above the profile and 5 %
  int periods = 0;

 private:
  Path path_;

 public:
  Car car;

 private:
  // Where it really is on the path, and how fast it may be there.
  void measure() {
    std::size_t at = follower.index();  // of where it will be, after its lag
    auto seen = path::beside(path_[at], car.truth());
    while (at > 0 && path::sense(path_[at]) * seen.along < 0 &&
           path::runs_on(path_[at - 1], path_[at]))
      seen = path::beside(path_[--at], car.truth());
    lateral.push_back(std::abs(seen.across));
    // It knows where it is to some centimetres only.
    constexpr double kUncertain = 30;
    const double distance = path::sense(path_[at]) * seen.along;
    const double allowed = std::max(path::speed_at(path_[at], distance - kUncertain),
                                    path::speed_at(path_[at], distance + kUncertain));
    const double slowest = 50;  // a chassis does not go slower
    too_fast =
        std::max(too_fast, std::abs(car.speed()) - std::max(1.05 * allowed, allowed + slowest));
  }
};

TEST(PathFollower, KeepsToTheCourseAtOneAndAtFourMetresASecond) {
  const auto route = path::route("sunlot-rddf.txt");
  ASSERT_TRUE(route.ok());
  for (const double speed : {1000.0, 4000.0}) {
    const auto path = path::make_path(*route, limits_of(car_chassis(), speed));
    ASSERT_TRUE(path.ok()) << path.error().detail();
    double worst = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      Drive drive({.chassis = car_chassis()}, *path, seed);
      drive.run();
      EXPECT_EQ(drive.follower.state(), State::kArrived) << speed;
      EXPECT_LE(drive.percentile(0.95), speed > 2000 ? 150 : 50) << speed << " " << seed;
      EXPECT_LE(drive.percentile(1), 600) << "the corridor is 4 m, the car 1.2 m wide";
      EXPECT_LE(drive.too_fast, 0) << speed << " " << seed;
      worst = std::max(worst, drive.percentile(0.95));
    }
    RecordProperty("p95_mm_at_" + std::to_string(static_cast<int>(speed)), std::to_string(worst));
    std::cout << "p95 at " << speed << ": " << worst << "\n";
  }
}

TEST(PathFollower, ArrivesAtTheEnd) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(8000, 0), waypoint(12000, 9000)};
  const auto path = path::make_path(route, limits_of(car_chassis(), 2000));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = car_chassis()}, *path);
  drive.run();
  EXPECT_EQ(drive.follower.state(), State::kArrived);
  EXPECT_NEAR(drive.car.truth().x, 12000, 100);
  EXPECT_NEAR(drive.car.truth().y, 9000, 100);
  EXPECT_EQ(drive.car.speed(), 0);
  EXPECT_LT(drive.follower.rest(), 50);
}

TEST(PathFollower, GoesForwardAndBackward) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(9000, 0),
                                         waypoint(3000, 1500, -1), waypoint(12000, 6000, 1, 6000)};
  for (const auto& chassis : {car_chassis(), indoor_chassis()}) {
    auto limits = limits_of(chassis, 1000);
    limits.corridor = 6000;
    auto wide = route;
    for (auto& point : wide) point.lbo = 6000;
    const auto path = path::make_path(wide, limits);
    ASSERT_TRUE(path.ok()) << path.error().detail();
    Drive drive({.chassis = chassis, .turns_at_rest = chassis.minTurningRadius == 0}, *path);
    drive.run();
    EXPECT_EQ(drive.follower.state(), State::kArrived);
    EXPECT_NEAR(drive.car.truth().x, 12000, 150);
    EXPECT_NEAR(drive.car.truth().y, 6000, 150);
    EXPECT_LE(drive.percentile(0.95), 100);
    EXPECT_LE(drive.too_fast, 0);
  }
}

TEST(PathFollower, TurnsInACornerWhereItCan) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(3000, 0), waypoint(500, 100)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 500));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = indoor_chassis(), .turns_at_rest = true}, *path);
  drive.run();
  EXPECT_EQ(drive.follower.state(), State::kArrived);
  EXPECT_NEAR(drive.car.truth().x, 500, 60);
  EXPECT_LE(drive.percentile(1), 80);
}

TEST(PathFollower, HoldsAndGoesOn) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(20000, 0)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 1000));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = indoor_chassis(), .turns_at_rest = true}, *path);
  for (int i = 0; i < 100; ++i) drive.period();
  EXPECT_GT(drive.car.speed(), 900);
  drive.follower.hold(true);
  for (int i = 0; i < 60; ++i) drive.period();
  EXPECT_EQ(drive.car.speed(), 0);
  const double stood = drive.car.truth().x;
  for (int i = 0; i < 60; ++i) drive.period();
  EXPECT_EQ(drive.car.truth().x, stood);
  drive.follower.hold(false);
  drive.run();
  EXPECT_EQ(drive.follower.state(), State::kArrived);
}

TEST(PathFollower, RevertsForAWhile) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(8000, 0), waypoint(12000, 8000)};
  const auto path = path::make_path(route, limits_of(car_chassis(), 2000));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = car_chassis()}, *path);
  while (drive.car.truth().y < 3000) drive.period();
  drive.follower.revert(10s);
  double back = 0;
  while (drive.follower.reverts()) {
    drive.period();
    back = std::min(back, drive.car.speed());
  }
  EXPECT_NEAR(back, -500, 5);
  EXPECT_LT(drive.car.truth().y, 1500);
  EXPECT_LT(drive.lateral.back(), 200);
  drive.run();
  EXPECT_EQ(drive.follower.state(), State::kArrived);
}

TEST(PathFollower, KeepsToWhatIsAllowed) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(20000, 0)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 1000));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = indoor_chassis(), .turns_at_rest = true}, *path);
  for (int i = 0; i < 100; ++i) drive.period(300);
  EXPECT_NEAR(drive.car.speed(), 300, 1);
  for (int i = 0; i < 20; ++i) drive.period(0);
  EXPECT_EQ(drive.car.speed(), 0);
}

TEST(PathFollower, GivesUpWhenItIsAstray) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(20000, 0, 1, 500)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 1000));
  ASSERT_TRUE(path.ok());
  PathFollower follower({.chassis = indoor_chassis(), .speed_max = 1000});
  follower.take(*path, {});
  EXPECT_GT(follower.follow({.x = 100}, 0, 1e9).speed, 0);
  EXPECT_EQ(follower.follow({.x = 100, .y = 700}, 0, 1e9).speed, 0);
  EXPECT_EQ(follower.state(), State::kAstray);
  follower.take(*path, {.x = 5000});
  EXPECT_EQ(follower.state(), State::kRunning);
  EXPECT_NEAR(follower.rest(), 15000, 100);
}

TEST(PathFollower, StandsWithoutAPath) {
  PathFollower follower({.chassis = indoor_chassis(), .speed_max = 1000});
  EXPECT_EQ(follower.follow({}, 0, 1e9).speed, 0);
  follower.take({}, {});
  EXPECT_EQ(follower.state(), State::kNoPath);
  EXPECT_EQ(follower.rest(), 0);
}

// As a plan leads: first away, then back beside where it stands.
TEST(PathFollower, BeginsWhereThePathBegins) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(-1000, 2000), waypoint(600, 2000),
                                         waypoint(600, 0), waypoint(5000, 0)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 500));
  ASSERT_TRUE(path.ok());
  PathFollower follower({.chassis = indoor_chassis(), .speed_max = 1000});
  follower.take(*path, {});
  EXPECT_EQ(follower.index(), 0U) << "though it looks where the path ends";
  const auto command = follower.follow({}, 0, 1e9);
  EXPECT_EQ(command.speed, 0);
  EXPECT_GT(command.omega, 0.5);
}

// A round ends where it begins: it is driven once, from its start.
TEST(PathFollower, BeginsARoundAtItsStart) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(9000, 0), waypoint(9000, 9000),
                                         waypoint(0, 9000), waypoint(0, 0)};
  const auto path = path::make_path(route, limits_of(indoor_chassis(), 1000));
  ASSERT_TRUE(path.ok());
  Drive drive({.chassis = indoor_chassis(), .turns_at_rest = true}, *path);
  EXPECT_GT(drive.follower.rest(), 30000);
  drive.run();
  EXPECT_EQ(drive.follower.state(), State::kArrived);
  EXPECT_GT(drive.periods, 600);
}

}  // namespace path_follower_test
}  // namespace rack::pilot
