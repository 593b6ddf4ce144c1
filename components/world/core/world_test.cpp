#include "components/world/core/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/random.h"
#include "components/world/core/people.h"
#include "components/world/core/rooms_fixture.h"
#include "components/world/core/scenery.h"
#include "tests/support/counted_new.h"

namespace rack::world {
namespace world_test {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// All there is, as text: numbers as they are to the last bit.
std::string all_of(const World& world) {
  Truth truth = world.make_truth();
  std::string text;
  const auto add = [&text](double value) { text += std::to_string(value) + " "; };
  for (const RobotTruth& robot : truth.robots) {
    for (const double value : {robot.pose.x, robot.pose.y, robot.pose.rho, robot.vx, robot.omega})
      add(value);
    text += std::to_string(robot.contacts.own()) + " " + std::to_string(robot.contacts.bumped);
  }
  for (const PersonTruth& person : truth.people)
    for (const double value : {person.at.x, person.at.y, person.vx, person.rho}) add(value);
  for (int i = 0; i < 36; ++i)
    add(world.measure({0, 0}, {.azimuth = i * 0.17}, world.now() - seconds(0.0123)).range);
  return text;
}

// Two robots that wander, slip and meet people.
WorldDescription busy(std::uint64_t seed) {
  WorldDescription description = rooms_world(6);
  description.seed = seed;
  description.people.avoids_share = 0.5;
  description.robots[0].slip = {.distance = 0.02, .distance_noise = 10, .turn_noise = 0.01};
  description.robots[0].acceleration = 800;
  description.robots[0].lag = std::chrono::milliseconds(60);
  description.robots[0].sensors[0].noise = {.range = 10, .short_share = 0.02};
  description.robots.push_back(room_robot());
  description.robots[1].name = "two";
  description.robots[1].start = {.x = 4500, .y = 8500};
  return description;
}

void wander(World& world, Random& random) {
  for (std::size_t i = 0; i < 2; ++i) {
    const double speed = random.uniform(-300, 600);
    const double turn = random.uniform(-200, 200);
    world.drive(i, std::array{speed + turn, speed - turn}, world.now());
  }
}

TEST(World, IsTheSameFromTheSameSeed) {
  std::array<std::string, 3> seen;
  for (std::size_t run = 0; run < seen.size(); ++run) {
    World world = made(busy(run == 2 ? 8 : 7));
    Random random(3);
    for (int i = 0; i < 600; ++i) {
      wander(world, random);
      world.advance(world.now() + seconds(0.1));
    }
    seen[run] = all_of(world);
  }
  EXPECT_EQ(seen[0], seen[1]);
  EXPECT_NE(seen[0], seen[2]);
}

TEST(World, IsTheSameInAnySlices) {
  World whole = made(busy(7));
  World sliced = made(busy(7));
  Random commands(3);
  Random same(3);
  Random slices(5);
  for (int i = 0; i < 400; ++i) {
    const tims::Time to = kBegin + i * seconds(0.1037);
    whole.advance(to);
    while (sliced.now() < to) {
      const auto slice = std::chrono::microseconds(1 + slices.below(20000));
      sliced.advance(std::min(to, sliced.now() + slice));
    }
    wander(whole, commands);
    wander(sliced, same);
    if (i % 50 == 7) {
      const ObstacleDescription box{.at = {1000, 9000 - 10.0 * i}, .length = 200, .width = 200};
      EXPECT_EQ(whole.put(box).ok(), sliced.put(box).ok());
    }
    if (i % 90 == 5) {
      const Pose pose{.x = 4500, .y = 1000.0 + i, .rho = 1};
      EXPECT_EQ(whole.place(0, pose).ok(), sliced.place(0, pose).ok());
    }
    ASSERT_EQ(all_of(whole), all_of(sliced)) << i;
  }
}

TEST(World, DoesNotDependOnWhatTheClockShows) {
  const WorldDescription description = busy(4);
  auto early = World::make(description, tims::Time{});
  World late = made(description);
  ASSERT_TRUE(early);
  early->advance(tims::Time{seconds(60)});
  late.advance(kBegin + seconds(60));
  EXPECT_EQ(all_of(*early), all_of(late));
}

// Ten minutes of movements, summed from the encoders.
TEST(World, WithoutSlipOdometryIsTheTruth) {
  for (const DriveKind kind :
       {DriveKind::kDifferential, DriveKind::kAckermann, DriveKind::kDoubleAckermann}) {
    WorldDescription description;
    description.ground = {{-1e6, -1e6}, {1e6, 1e6}};
    description.robots = {room_robot()};
    description.robots[0].kind = kind;
    description.robots[0].acceleration = 1000;
    description.robots[0].steering_rate = 0.5;
    description.robots[0].lag = std::chrono::milliseconds(80);
    World world = made(description);
    Pose odometry = description.robots[0].start;
    Random random(9);
    std::array<double, kMotorsMax> now{};
    for (int step = 0; step < 120000; ++step) {
      if (step % 200 == 0)
        world.drive(
            0, device::ChassisSpeed{.vx = random.uniform(200, 900), .omega = random.uniform(-1, 1)},
            world.now());
      world.advance(world.now() + kStep);
      const auto motors = world.motors(0);
      for (std::size_t i = 0; i < motors.size(); ++i)
        now[i] = world.wheels(0).is_steering(i) ? motors[i].position : motors[i].speed;
      const auto speed = world.wheels(0).movement(std::span(now).first(motors.size()));
      const double turn = static_cast<double>(speed.omega) * 0.005;
      odometry = odometry + Pose{.rho = turn / 2} +
                 Pose{.x = static_cast<double>(speed.vx) * 0.005,
                      .y = static_cast<double>(speed.vy) * 0.005,
                      .rho = turn / 2};
    }
    const Pose error = world.pose(0, world.now()) - odometry;
    EXPECT_LT(std::hypot(error.x, error.y), 0.1);
    EXPECT_LT(std::abs(signed_angle(error.rho)), 1e-5);
    EXPECT_GT(world.make_truth().robots[0].travelled, 200e3);
  }
}

TEST(World, ARobotStopsAtTheWallAndCountsOneContact) {
  World world = made(rooms_world());
  world.drive(0, std::array{500.0, 500.0}, world.now());
  world.advance(kBegin + seconds(10));
  const RobotTruth stopped = world.make_truth().robots[0];
  EXPECT_TRUE(stopped.is_blocked);
  EXPECT_EQ(stopped.contacts, (Contacts{.walls = 1}));
  EXPECT_EQ(stopped.vx, 0);
  EXPECT_NEAR(stopped.pose.x + 250, 6000, 3);
  EXPECT_LE(stopped.pose.x + 250, 6000);
  EXPECT_NEAR(world.motors(0)[0].position, 5000, 1e-6) << "its wheels turn on";
  world.drive(0, std::array{-500.0, -500.0}, world.now());
  world.advance(kBegin + seconds(12));
  EXPECT_FALSE(world.make_truth().robots[0].is_blocked);
  EXPECT_NEAR(world.make_truth().robots[0].pose.x, stopped.pose.x - 1000, 1e-3);
  world.drive(0, std::array{500.0, 500.0}, world.now());
  world.advance(kBegin + seconds(20));
  EXPECT_EQ(world.make_truth().robots[0].contacts.walls, 2U);
}

TEST(World, CountsWhatWasMet) {
  WorldDescription description = rooms_world();
  description.robots.push_back(room_robot());
  description.robots[1].start = {.x = 3000, .y = 4000};
  World world = made(description);
  ASSERT_TRUE(world.put({.shape = Shape::kCircle, .at = {5000, 2500}, .radius = 200}));
  world.drive(0, std::array{500.0, 500.0}, world.now());
  world.advance(kBegin + seconds(5));
  EXPECT_EQ(world.make_truth().robots[0].contacts, (Contacts{.obstacles = 1}));
  EXPECT_NEAR(world.make_truth().robots[0].pose.x, 4550, 3);
  ASSERT_TRUE(world.place(0, {.x = 3000, .y = 2500, .rho = kPi / 2}));
  world.drive(0, std::array{500.0, 500.0}, world.now());
  world.advance(kBegin + seconds(10));
  EXPECT_EQ(world.make_truth().robots[0].contacts, (Contacts{.obstacles = 1, .robots = 1}));
  EXPECT_EQ(world.make_truth().robots[1].contacts, Contacts{}) << "it stood there";
}

TEST(World, AFrozenPersonIsMetAndItIsTheRobotsFault) {
  WorldDescription description = rooms_world(1);
  World world = made(description);
  world.freeze_people(true);
  const PersonTruth person = world.make_truth().people[0];
  const MapPoint start = {person.at.x > 3000 ? person.at.x - 800 : person.at.x + 800, person.at.y};
  ASSERT_TRUE(world.place(0, {.x = start.x, .y = start.y, .rho = start.x > person.at.x ? kPi : 0}));
  world.drive(0, std::array{300.0, 300.0}, world.now());
  world.advance(kBegin + seconds(20));
  const Truth truth = world.make_truth();
  EXPECT_TRUE(truth.people_frozen);
  EXPECT_EQ(truth.robots[0].contacts, (Contacts{.people = 1}));
  EXPECT_EQ(truth.people[0].at.x, person.at.x);
  world.freeze_people(false);
  world.advance(kBegin + seconds(60));
  EXPECT_NE(world.make_truth().people[0].at.x, person.at.x);
}

TEST(World, KidnapsAtOnceAndWithoutSmearing) {
  World world = made(rooms_world());
  world.drive(0, std::array{300.0, 300.0}, world.now());
  world.advance(kBegin + seconds(1.0021));
  const tims::Time before = world.now() - std::chrono::microseconds(1);
  ASSERT_TRUE(world.place(0, {.x = 1000, .y = 8000, .rho = 1}));
  EXPECT_NEAR(world.pose(0, before).x, 3300, 5);
  EXPECT_EQ(world.pose(0, world.now()).x, 1000);
  EXPECT_EQ(world.make_truth().robots[0].pose.y, 8000);
  const tims::Time then = world.now();
  world.advance(then + seconds(0.3));
  EXPECT_EQ(world.pose(0, then).x, 1000) << "its wheels stand";
  EXPECT_NEAR(world.pose(0, before).x, 3300, 5);
  EXPECT_EQ(world.make_truth().robots[0].contacts, Contacts{});
  const auto refused = world.place(0, {.x = 2100, .y = 7500});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), tims::Errc::kRefused);
  EXPECT_EQ(refused.error().detail(), "robot one would stand in an obstacle at x 2100 y 7500");
  EXPECT_FALSE(world.place(0, {.x = 10, .y = 10}));
  EXPECT_FALSE(world.place(0, {.x = -9000, .y = 10}));
  EXPECT_FALSE(world.place(0, {.x = kNan}));
}

TEST(World, ObstaclesComeAndGo) {
  World world = made(rooms_world());
  world.advance(kBegin + seconds(1));
  const auto ahead = [&](tims::Time at) { return world.look({0, 0}, {}, at); };
  const ObstacleDescription box{.at = {4500, 2500}, .length = 400, .width = 400};
  EXPECT_EQ(ahead(world.now()).met, Met::kWall);
  const auto id = world.put(box);
  ASSERT_TRUE(id);
  EXPECT_EQ(ahead(world.now()).met, Met::kObstacle);
  EXPECT_EQ(ahead(world.now()).id, *id);
  EXPECT_NEAR(ahead(world.now()).range, 1200, 1e-9);
  EXPECT_EQ(ahead(world.now() - seconds(0.001)).met, Met::kWall) << "it was not there yet";
  const tims::Time then = world.now();
  world.advance(then + seconds(0.5));
  EXPECT_TRUE(world.remove(*id));
  EXPECT_FALSE(world.remove(*id));
  EXPECT_EQ(ahead(world.now()).met, Met::kWall);
  EXPECT_EQ(ahead(then).met, Met::kObstacle) << "it was there then";
  EXPECT_FALSE(world.put({.at = {3100, 2500}})) << "the robot is there";
  EXPECT_FALSE(world.put({.at = {kNan, 0}}));
  EXPECT_FALSE(world.put({.length = -1}));
  for (std::size_t round = 0; round < 3; ++round) {
    std::size_t first = 0;
    for (std::size_t i = 0; i < kPutMax; ++i) {
      const auto more = world.put(box);
      ASSERT_TRUE(more);
      if (i == 0) first = *more;
    }
    EXPECT_EQ(world.put(box).error().code(), tims::Errc::kFull);
    EXPECT_EQ(world.make_truth().obstacles.size(), kPutMax);
    for (std::size_t i = 0; i < kPutMax; ++i) EXPECT_TRUE(world.remove(first + i));
  }
  EXPECT_EQ(world.make_truth().obstacles.size(), 0U);
}

TEST(World, AllocatesNothingOnceItIsMade) {
  World world = made(busy(2));
  Truth truth = world.make_truth();
  Random random(1);
  double sum = 0;
  int refused = 0;
  // What is refused has a text.
  const auto count = [&](auto&& act) {
    const std::size_t before = tims::test::allocations();
    const bool done = act();
    const std::size_t made = tims::test::allocations() - before;
    if (done)
      EXPECT_EQ(made, 0U);
    else
      ++refused;
  };
  for (int i = 0; i < 300; ++i) {
    count([&] {
      wander(world, random);
      world.advance(world.now() + seconds(0.05));
      for (int ray = 0; ray < 181; ++ray)
        sum += world.measure({0, 0}, {.azimuth = 0.0174 * ray}, world.now()).range;
      world.truth(truth);
      return true;
    });
    std::size_t id = 0;
    count([&] {
      const auto put = world.put({.at = {1000, 9000}, .length = 200, .width = 200});
      id = put ? *put : 0;
      return put.ok();
    });
    if (i % 2 == 0) count([&] { return world.remove(id) || id == 0; });
    count([&] { return world.place(1, {.x = 4500, .y = 8500}).ok(); });
  }
  EXPECT_GT(sum, 0);
  EXPECT_LT(refused, 300);
}

TEST(World, NobodyIsInWallsWhileRobotsDriveAbout) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const WorldDescription description = busy(seed);
    World world = made(description);
    const Scenery scenery(description.walls, description.obstacles);
    Truth truth = world.make_truth();
    Random random(seed);
    for (int i = 0; i < 20 * 60 * 10; ++i) {
      if (i % 20 == 0) wander(world, random);
      world.advance(world.now() + seconds(0.1));
      world.truth(truth);
      for (const PersonTruth& person : truth.people) {
        ASSERT_GE(scenery.clearance(person.at, 1000), 249.9);
        for (const RobotTruth& robot : truth.robots) {
          const Box hull = Box::of({robot.pose.x, robot.pose.y}, robot.pose.rho, 500 - 2, 400 - 2);
          ASSERT_GE(distance(person.at, hull), kBodyRadius - 1) << "seed " << seed << " at " << i;
        }
      }
      for (const RobotTruth& robot : truth.robots)
        ASSERT_EQ(scenery.touches(Box::of({robot.pose.x, robot.pose.y}, robot.pose.rho, 498, 398)),
                  Met::kNothing);
    }
    EXPECT_GT(truth.robots[0].contacts.own(), 0U);
  }
}

TEST(World, ReportsWhyItIsImpossible) {
  WorldDescription in_wall = rooms_world();
  in_wall.robots[0].start = {.x = 3000, .y = 4900};
  EXPECT_THAT(World::make(in_wall, kBegin).error().detail(),
              HasSubstr("robot one starts in a wall"));
  WorldDescription twice = rooms_world();
  twice.robots.push_back(twice.robots[0]);
  EXPECT_THAT(World::make(twice, kBegin).error().detail(), HasSubstr("another robot"));
  EXPECT_THAT(World::make(rooms_world(400), kBegin).error().detail(),
              HasSubstr("there is room for"));
  WorldDescription nothing;
  EXPECT_TRUE(World::make(nothing, kBegin));
}

TEST(World, KnowsItsRobotsByName) {
  World world = made(rooms_world());
  EXPECT_EQ(world.find_robot("one"), 0U);
  EXPECT_EQ(world.find_robot("other"), std::nullopt);
  EXPECT_EQ(world.find_sensor("one", "laser"), (SensorId{0, 0}));
  EXPECT_EQ(world.find_sensor("one", "lasers"), std::nullopt);
  EXPECT_TRUE(world.is_plugged({0, 0}));
  world.plug({0, 0}, false);
  EXPECT_FALSE(world.is_plugged({0, 0}));
  world.advance(kBegin - seconds(10));
  EXPECT_EQ(world.now(), kBegin);
}

// Somebody walks towards a robot that drives, and does not see it: not the robot's doing, as long
// as it then stops.
TEST(World, APersonWalkingIntoARobotIsNotItsContact) {
  WorldDescription description = rooms_world();
  description.people = {.avoids_share = 0, .walks = {{.places = {{5000, 2500}, {1000, 2500}}}}};
  description.robots[0].start = {.x = 1000, .y = 2500};
  World world = made(description);
  Truth truth = world.make_truth();
  const auto drive = [&](double speed, double for_seconds) {
    const std::array<double, 2> rims = {speed, speed};
    world.drive(0, rims, world.now());
    const tims::Time end = world.now() + seconds(for_seconds);
    while (world.now() < end) {
      world.advance(world.now() + kStep);
      world.truth(truth);
    }
  };
  for (int i = 0; i < 4000 && truth.robots[0].contacts.bumped == 0; ++i) drive(300, 0.005);
  EXPECT_EQ(truth.robots[0].contacts.bumped, 1U);
  drive(300, 0.5);  // until it has noticed
  EXPECT_EQ(truth.robots[0].contacts.own(), 0U);
  drive(0, 1);
  EXPECT_FALSE(truth.robots[0].is_blocked) << "the person has stepped back";
  EXPECT_EQ(truth.robots[0].contacts.own(), 0U);
  drive(300, 30);
  EXPECT_GE(truth.robots[0].contacts.own(), 1U) << "it drives on against somebody, or the wall";
}

}  // namespace world_test
}  // namespace rack::world
