// People and boxes that move past a robot in a bare room, scan by scan.
#include "components/perception/object_recogniser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "components/perception/room_fixture.h"
#include "tests/support/counted_new.h"

namespace rack::perception {
namespace object_recogniser_test {

ObjRecogData message_of(ObjectRecogniser& recogniser) {
  ObjRecogData data;
  recogniser.to_message(data);
  return data;
}

// Walks from x = -3 m at 1 m/s along y = 2 m, ten scans a second.
void walk(Room& world, ObjectRecogniser& recogniser, int scans, const Pose& robot = {}) {
  for (int i = 0; i < scans; ++i, world.time += 100)
    ASSERT_TRUE(recogniser.take(world.scan(Room::person(-3000 + i * 100.0, 2000), robot),
                                {.pos = robot.position()}));
}

TEST(ObjectRecogniser, APersonWalks) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  walk(world, recogniser, 50);
  const ObjRecogData data = message_of(recogniser);
  ASSERT_EQ(data.objects.size(), 1U);
  const ObjRecogObject& person = data.objects[0];
  EXPECT_EQ(data.recordingTime, TimeStamp(world.time - 100));
  EXPECT_EQ(person.type, object_type::kPedestrian);
  EXPECT_NEAR(person.pos.x, 1900, 100);
  EXPECT_NEAR(person.pos.y, 2000, 100);
  EXPECT_NEAR(person.vel.x, 1000, 150);
  EXPECT_NEAR(person.vel.y, 0, 150);
  EXPECT_GT(person.prob, 0.9F);
  EXPECT_GE(person.dim.x, 600);
  EXPECT_GT(person.varPos.x, 0);
  EXPECT_GT(person.varVel.x, 0);
}

TEST(ObjectRecogniser, ReportsInTheRobotsFrame) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  const Pose robot{.x = 1000, .y = -1000, .rho = radians(90)};
  walk(world, recogniser, 50, robot);
  const ObjRecogData data = message_of(recogniser);
  ASSERT_EQ(data.objects.size(), 1U);
  EXPECT_EQ(data.refPos.x, 1000);
  EXPECT_NEAR(data.objects[0].pos.x, 3000, 150);
  EXPECT_NEAR(data.objects[0].pos.y, -900, 150);
  EXPECT_NEAR(data.objects[0].vel.y, -1000, 150);
}

TEST(ObjectRecogniser, APersonThatStopsKeepsItsNumberAndHasNoSpeed) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  walk(world, recogniser, 40);
  const i32 id = message_of(recogniser).objects.at(0).objectId;
  for (int i = 0; i < 100; ++i, world.time += 100)
    recogniser.take(world.scan(Room::person(900, 2000)), {});
  const ObjRecogData data = message_of(recogniser);
  ASSERT_EQ(data.objects.size(), 1U);
  EXPECT_EQ(data.objects[0].objectId, id);
  EXPECT_EQ(data.objects[0].vel.x, 0);
}

TEST(ObjectRecogniser, APersonThatLeftIsReportedForHalfASecond) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  walk(world, recogniser, 40);
  for (int i = 0; i < 4; ++i, world.time += 100) recogniser.take(world.scan({}), {});
  EXPECT_EQ(message_of(recogniser).objects.size(), 1U);
  for (int i = 0; i < 2; ++i, world.time += 100) recogniser.take(world.scan({}), {});
  EXPECT_TRUE(message_of(recogniser).objects.empty());
}

TEST(ObjectRecogniser, APersonPassingBehindAPillarKeepsItsNumber) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  const Room::Circle pillar{{0, 1000}, 100};
  std::set<i32> ids;
  for (int i = 0; i < 60; ++i, world.time += 100) {
    auto things = Room::person(-3000 + i * 100.0, 3000);
    things.push_back(pillar);
    recogniser.take(world.scan(things), {});
    for (const ObjRecogObject& object : message_of(recogniser).objects) ids.insert(object.objectId);
  }
  EXPECT_EQ(ids.size(), 1U);
  EXPECT_EQ(message_of(recogniser).objects.size(), 1U);
}

// Without a map: when more than a third of a scan has moved, it is the position that slips.
TEST(ObjectRecogniser, NothingBeginsWhileTheScanSlips) {
  for (const bool slips : {false, true}) {
    Room world;
    ObjectRecogniser recogniser({}, nullptr);
    for (int i = 0; i < 30; ++i, world.time += 100) recogniser.take(world.scan({}), {});
    const Room::Circle thing{{1200, 0}, slips ? 1100.0 : 500.0};
    for (int i = 0; i < 10; ++i, world.time += 100) recogniser.take(world.scan({thing}), {});
    EXPECT_EQ(recogniser.tracks().empty(), slips);
  }
}

// The reported pose of the robot slips: it puts a column of the map at a place that was free until
// now.
TEST(ObjectRecogniser, NothingBeginsToMoveWhileThePositionContradictsTheMap) {
  const Room::Circle column{{3500, 0}, 1500};
  DxfDrawing drawing = room();
  for (int i = 0; i < 36; ++i) {
    const auto at = [](int n) -> DxfPoint {
      return {1.5 * std::sin(radians(n * 10)), 3.5 + 1.5 * std::cos(radians(n * 10))};
    };
    drawing.lines.push_back({at(i), at(i + 1)});
  }
  const auto map = localisation::read_map(drawing, 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  const auto field = localisation::LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  for (const bool slips : {false, true}) {
    Room world;
    ObjectRecogniser recogniser({}, &*field);
    for (int i = 0; i < 55; ++i, world.time += 100) {
      std::vector<Room::Circle> things;
      if (i >= 30) things = Room::person(-3000 + (i - 30) * 100.0, 3000);
      if (i >= 30 || !slips) things.push_back(column);
      ASSERT_TRUE(recogniser.take(world.scan(things), {}));
    }
    const ObjRecogData data = message_of(recogniser);
    const auto moves = [](const ObjRecogObject& object) { return object.vel.x != 0; };
    EXPECT_EQ(std::ranges::count_if(data.objects, moves), slips ? 0 : 1);
  }
}

TEST(ObjectRecogniser, WhatAlwaysStoodThereIsNoObjectWithoutAMap) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  for (int i = 0; i < 100; ++i, world.time += 100) {
    const Pose robot{.x = -2000 + i * 40.0, .y = -500, .rho = heading(i * 0.02)};
    auto things = Room::person(2000, 2000);
    things.push_back({{-1500, 2500}, 200});
    recogniser.take(world.scan(things, robot), {.pos = robot.position()});
    EXPECT_TRUE(message_of(recogniser).objects.empty()) << i;
  }
}

TEST(ObjectRecogniser, WithAMapWhatItDoesNotHaveIsOne) {
  const auto map = localisation::read_map(room(), 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  const auto field = localisation::LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  Room world;
  ObjectRecogniser recogniser({}, &*field);
  for (int i = 0; i < 20; ++i, world.time += 100)
    recogniser.take(world.scan({{{2000, 1000}, 300}}), {});
  const ObjRecogData data = message_of(recogniser);
  ASSERT_EQ(data.objects.size(), 1U);
  EXPECT_NE(data.objects[0].type, object_type::kPedestrian);
  EXPECT_EQ(data.objects[0].vel.x, 0);
  EXPECT_NEAR(data.objects[0].pos.x, 2000, 250);
}

// The position is wrong by as much as odometry is after some metres of turning.
TEST(ObjectRecogniser, APositionThatDriftsMakesNoObjects) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  for (int i = 0; i < 200; ++i, world.time += 100) {
    const Pose robot{.x = i * 10.0, .y = -500, .rho = heading(i * 0.05)};
    const Pose known{.x = i * 10.4, .y = -500 + i * 2.0, .rho = heading(i * 0.054)};
    auto things = Room::person(2000, 2000);
    recogniser.take(world.scan(things, robot), {.pos = known.position()});
    EXPECT_TRUE(message_of(recogniser).objects.empty()) << i;
  }
}

TEST(ObjectRecogniser, HostileScansAndPositions) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  PositionData wrong;
  wrong.pos.rho = std::numeric_limits<f32>::quiet_NaN();
  EXPECT_FALSE(recogniser.take(world.scan({}), wrong));
  Scan2dData scan = world.scan({});
  EXPECT_TRUE(recogniser.take(scan, {}));
  EXPECT_FALSE(recogniser.take(scan, {})) << "the same again";
  scan.recordingTime = world.time += 100;
  scan.points.clear();
  EXPECT_TRUE(recogniser.take(scan, {})) << "empty";
  scan = world.scan({});
  scan.recordingTime = world.time += 100;
  for (ScanPoint& point : scan.points) point.type = scan_point::kInvalid;
  EXPECT_TRUE(recogniser.take(scan, {})) << "nothing valid";
  scan.recordingTime = world.time += 100;
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    scan.points[i] = {.x = i % 2 == 0 ? 2147483647 : -2147483647, .y = 2147483647};
  EXPECT_TRUE(recogniser.take(scan, {})) << "as far as numbers go";
  EXPECT_TRUE(message_of(recogniser).objects.empty());
}

TEST(ObjectRecogniser, WhenTimeGoesBackEverythingBeginsAgain) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  walk(world, recogniser, 40);
  ASSERT_EQ(message_of(recogniser).objects.size(), 1U);
  world.time -= 3600000;
  ASSERT_TRUE(recogniser.take(world.scan(Room::person(1000, 2000)), {}));
  EXPECT_TRUE(message_of(recogniser).objects.empty());
  world.time += 100;
  walk(world, recogniser, 40);
  EXPECT_EQ(message_of(recogniser).objects.size(), 1U);
  ASSERT_TRUE(recogniser.take(world.scan({}), {.pos = Pose{.x = 50000}.position()}))
      << "carried away";
  EXPECT_TRUE(message_of(recogniser).objects.empty());
}

TEST(ObjectRecogniser, ManyObjectsAndPointsFitAndAllocateNothing) {
  const std::array<localisation::MapLine, 2> walls = {
      {{{-20000, -20000}, {20000, -20000}}, {{-20000, 20000}, {20000, 20000}}}};
  const auto map = localisation::draw_walls(walls, 100);
  ASSERT_TRUE(map.ok());
  const auto field = localisation::LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  ObjectRecogniser recogniser({.objects_max = 100}, &*field);
  ObjRecogData data;
  reserve_all(data);
  Scan2dData scan;
  reserve_all(scan);
  std::uint64_t before = 0;
  // 122 poles around, seen by as many beams as a scan has.
  for (u32 n = 0; n < 10; ++n) {
    scan.recordingTime = 1000 + 100 * n;
    scan.points.clear();
    for (int i = 0; i < 8000; ++i) {
      const bool pole = i % 66 < 20;
      const double range = pole ? 15000 : 30000;
      const double angle = radians(i * 360.0 / 8000);
      scan.points.push_back({.x = whole_millimetres(range * std::cos(angle)),
                             .y = whole_millimetres(range * std::sin(angle)),
                             .type = pole ? 0 : 0x30});
    }
    if (n == 5) before = tims::test::allocations();
    ASSERT_TRUE(recogniser.take(scan, {}));
    recogniser.to_message(data);
  }
  EXPECT_EQ(tims::test::allocations(), before);
  EXPECT_EQ(data.objects.size(), 100U);
  EXPECT_GT(recogniser.tracks().size(), 100U);
  EXPECT_LE(recogniser.tracks().size(), ObjectTracker::kTracksMax);
}

TEST(ObjectRecogniser, AnObjectIsStopped) {
  Room world;
  ObjectRecogniser recogniser({}, nullptr);
  walk(world, recogniser, 40);
  const i32 id = message_of(recogniser).objects.at(0).objectId;
  EXPECT_FALSE(recogniser.stop(id + 1));
  EXPECT_TRUE(recogniser.stop(id));
  EXPECT_TRUE(message_of(recogniser).objects.empty());
}

}  // namespace object_recogniser_test
}  // namespace rack::perception
