#include "components/pilot/obstacle_stop.h"

#include <gtest/gtest.h>

#include "components/path/route_fixture.h"
#include "components/pilot/car_fixture.h"

namespace rack::pilot {
namespace obstacle_stop_test {

using namespace std::chrono_literals;

struct Spot {
  double x = 0;
  double y = 0;
};

// What a scanner at the reference point sees of points in the world.
Scan2dData scan_of(const std::vector<Spot>& spots, const Pose& from, std::mt19937& random,
                   double noise = 0, i32 type = 0) {
  std::normal_distribution<double> error(0, 1);
  Scan2dData scan;
  for (const Spot& spot : spots) {
    const Pose seen = Pose{.x = spot.x, .y = spot.y} - from;
    scan.points.push_back({.x = whole_millimetres(seen.x + noise * error(random)),
                           .y = whole_millimetres(seen.y + noise * error(random)),
                           .type = type});
  }
  return scan;
}

bool touches(const ChassisParamData& chassis, const Pose& at, const std::vector<Spot>& spots) {
  return std::any_of(spots.begin(), spots.end(), [&](const Spot& spot) {
    const Pose seen = Pose{.x = spot.x, .y = spot.y} - at;
    return seen.x < chassis.boundaryFront && seen.x > -chassis.boundaryBack &&
           seen.y < chassis.boundaryRight && seen.y > -chassis.boundaryLeft;
  });
}

// A wall across the path, 1 m wide, with its centre there.
std::vector<Spot> wall_at(const Pose& at, double shift) {
  std::vector<Spot> spots;
  for (int i = -10; i <= 10; ++i) {
    const double across = shift + i * 50;
    spots.push_back({at.x - across * std::sin(at.rho), at.y + across * std::cos(at.rho)});
  }
  return spots;
}

constexpr auto kReaction = 170ms;  // the lag, a period, and the age of a scan

TEST(ObstacleStop, RefusesABreakConstantThatDoesNotStop) {
  ChassisParamData chassis = car_chassis();
  EXPECT_TRUE(check_braking(chassis, 4000, kReaction).ok());
  chassis.breakConstant = 1;
  const auto refused = check_braking(chassis, 4000, kReaction);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().detail().find("1.17"), std::string::npos) << refused.error().detail();
  EXPECT_NE(refused.error().detail().find("3320"), std::string::npos) << refused.error().detail();
  EXPECT_TRUE(check_braking(chassis, 3320, kReaction).ok());
  chassis.decMax = 0;
  EXPECT_FALSE(check_braking(chassis, 100, kReaction).ok());
}

class OnAPath : public ::testing::Test {
 protected:
  OnAPath() { follower.take(path, {}); }
  double allowed(const std::vector<Spot>& spots, i32 type = 0) {
    return stop.speed_max(scan_of(spots, {}, random, 0, type), {}, {}, follower);
  }
  // 1.5 m ahead, then a bend to the right of 2 m.
  std::vector<PolarSpline> path = [] {
    std::vector<PolarSpline> splines = {path::line({}, 1500)};
    splines.push_back(path::arc({.x = 1500}, 2000, 3142));
    return splines;
  }();
  ChassisParamData chassis = indoor_chassis();
  PathFollower follower{{.chassis = indoor_chassis(), .speed_max = 1000}};
  ObstacleStop stop{indoor_chassis(), kReaction};
  std::mt19937 random{1};
};

TEST_F(OnAPath, GoesAsFastAsTheFreeDistanceAllows) {
  EXPECT_GT(allowed({}), 1e6);
  EXPECT_NEAR(allowed({{900, 0}}), 500, 2) << "250 hull, 50 and 100 margins";
  EXPECT_EQ(allowed({{390, 0}}), 0);
  EXPECT_NEAR(stop.free_distance(), 90, 1);
  EXPECT_NEAR(allowed({{900, 0}}, 3), 500.0 / 3, 2) << "it moves";
  EXPECT_GT(allowed({{900, 0}}, 1), 1e6) << "a landmark";
  EXPECT_NEAR(allowed({{500, 400}}), 400, 2) << "100 mm beside";
  EXPECT_GT(allowed({{-260, 0}}), 1e6) << "behind";
}

// The hull is 250 mm wide to each side, its margin 50 mm.
TEST_F(OnAPath, PassesSlowlyWhatIsALittleWithinItsMarginBesideIt) {
  EXPECT_NEAR(allowed({{600, 295}}), 200, 2) << "it slows down before";
  EXPECT_EQ(allowed({{400, 295}}), 100);
  EXPECT_EQ(allowed({{0, -289}}), 100) << "a quarter of the margin";
  EXPECT_EQ(allowed({{0, -286}}), 0);
  EXPECT_EQ(allowed({{0, 302}}), 100) << "it does not creep beside it";
  EXPECT_EQ(allowed({{0, 295}}, 3), 0) << "it moves";
  EXPECT_EQ(allowed({{600, 295}, {310, 0}}), 0) << "nor does it run into something else";
}

TEST_F(OnAPath, LooksAlongTheBend) {
  EXPECT_LT(allowed({{2914, 586}}), 3000) << "on the arc";
  EXPECT_GT(allowed({{3500, -1000}}), 5000) << "where the path does not lead";
}

TEST_F(OnAPath, NeedsNoMoreRoomBehindTheEndThanTheHull) {
  const std::vector<PolarSpline> here = {path::line({}, 500)};
  follower.take(here, {});
  EXPECT_NEAR(allowed({{790, 0}}), 390, 2) << "300 hull and margin, 100 more of it where it goes";
  EXPECT_GT(allowed({{810, 0}}), 500);
}

TEST_F(OnAPath, IsMoreCarefulWhileItHolds) {
  const double before = allowed({{900, 0}});
  follower.hold(true);
  EXPECT_LT(allowed({{900, 0}}), before - 140);
}

struct Trial {
  bool touched = false;
  bool stopped = false;
};

// An obstacle appears on the path of a car at full speed.
Trial drive_into(const CarModel& model, double speed, bool bend, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(0, 1);
  const ChassisParamData& chassis = model.chassis;
  std::vector<PolarSpline> path = {path::line({}, 8000)};
  const double radius = std::max({1000.0, 1.3 * chassis.minTurningRadius, speed * speed / 1500}) *
                        (any(random) < 0.5 ? -1 : 1);
  if (bend) path.push_back(path::arc({.x = 8000}, static_cast<i32>(radius), 6000));
  const Pose end = path::pose_at(path.back(), path.back().length);
  path.push_back(path::line(end, 30000));
  for (PolarSpline& spline : path) {
    spline.vMax = static_cast<i32>(speed);
    spline.accMax = spline.decMax = static_cast<i32>(0.7 * chassis.decMax);
    spline.lbo = 3000;
  }
  path::set_speeds(path, speed);
  path[0].vStart = static_cast<i32>(speed);
  Car car(model, {}, seed);
  car.start_with(speed);
  PathFollower follower({.chassis = chassis, .speed_max = speed});
  follower.take(path, {});
  ObstacleStop stop(chassis, kReaction);
  const double appears_after = 2000 + 12000 * any(random);
  const double reacts = std::chrono::duration<double>(kReaction).count();
  std::vector<Spot> wall;
  Trial trial;
  Pose seen_from = car.measured();
  Scan2dData scan;
  double distance = 0;
  for (int period = 0; period < 600 && (wall.empty() || car.speed() > 0); ++period) {
    const Pose at = car.measured();
    const auto command =
        follower.follow(at, car.speed(), stop.speed_max(scan, seen_from, at, follower));
    for (int i = 0; i < 10; ++i) {
      // The newest scan of the next period is 15 ms old then.
      if (i == 7) {
        seen_from = car.measured();
        scan = scan_of(wall, car.truth(), random, 10);
      }
      car.step(command);
      distance += car.speed() * Car::kStep;
      if (wall.empty() && distance > appears_after) {
        const double v = car.speed();
        const double brakes = v * reacts + v * v / (2.0 * chassis.decMax);
        double wall_distance = distance + chassis.boundaryFront + brakes + 500;
        std::size_t k = 0;
        while (k + 1 < path.size() && wall_distance > path::size(path[k]))
          wall_distance -= path::size(path[k++]);
        const double side = (any(random) - 0.5) * 2 * (chassis.boundaryLeft + 400.0);
        wall = wall_at(path::pose_at(path[k], wall_distance), side);
      }
      trial.touched = trial.touched || touches(chassis, car.truth(), wall);
    }
  }
  trial.stopped = car.speed() == 0;
  return trial;
}

TEST(ObstacleStop, StopsBeforeAThousandWallsThatAppearSuddenly) {
  int stopped = 0;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    const bool big = seed % 2 == 0;
    const CarModel model = big ? CarModel{.chassis = car_chassis()}
                               : CarModel{.chassis = indoor_chassis(), .turns_at_rest = true};
    const double speed = (big ? 4000 : 1000) * (0.25 + 0.75 * (seed % 7) / 6.0);
    const Trial trial = drive_into(model, speed, seed % 3 == 0, seed);
    EXPECT_FALSE(trial.touched) << "seed " << seed;
    stopped += trial.stopped ? 1 : 0;
  }
  EXPECT_GT(stopped, 700) << "the others pass by";
}

// A corner of the hull is 354 mm from the middle; the margin is 50 mm.
TEST(ObstacleStop, ItsCornersSwingOutWhenItTurns) {
  std::mt19937 random(1);
  const ChassisParamData chassis = indoor_chassis();
  const ObstacleStop stop(chassis, kReaction);
  const auto may_turn = [&](const Spot& spot, double omega) {
    return stop.may_turn(scan_of({spot}, {}, random), {}, {}, omega);
  };
  EXPECT_TRUE(may_turn({500, 0}, 1));
  EXPECT_TRUE(may_turn({500, 0}, -1));
  EXPECT_FALSE(may_turn({320, 200}, -1)) << "its right corner comes closer";
  EXPECT_TRUE(may_turn({320, 200}, 1));
  EXPECT_FALSE(may_turn({310, 0}, 1));
  EXPECT_TRUE(may_turn({0, 800}, 1));
  EXPECT_TRUE(stop.may_turn({}, {}, {}, 1));
}

// What is already within the margin does not hold it for ever: a robot beside a wall.
TEST(ObstacleStop, ItTurnsAwayFromWhatIsWithinItsMargin) {
  std::mt19937 random(1);
  const ObstacleStop stop(indoor_chassis(), kReaction);
  std::vector<Spot> wall;
  for (int x = -400; x <= 400; x += 20) wall.push_back({1.0 * x, -293});
  EXPECT_FALSE(stop.may_turn(scan_of(wall, {}, random), {}, {}, 1));
  const Spot ahead_left{293, -240};
  EXPECT_TRUE(stop.may_turn(scan_of({ahead_left}, {}, random), {}, {}, -1)) << "it comes no closer";
}

}  // namespace obstacle_stop_test
}  // namespace rack::pilot
