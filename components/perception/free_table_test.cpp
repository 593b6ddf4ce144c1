#include "components/perception/free_table.h"

#include <gtest/gtest.h>

#include "components/perception/room_fixture.h"

namespace rack::perception {
namespace free_table_test {

using Seen = FreeTable::Seen;

TEST(FreeTable, WhatIsBeforeAtAndBehindAThing) {
  Room world;
  const FreeTable table = table_of(world.scan({{{3000, 0}, 200}}));
  EXPECT_EQ(table.look({2000, 0}, 60), Seen::kThrough);
  EXPECT_EQ(table.look({2800, 0}, 60), Seen::kMet);
  EXPECT_EQ(table.look({4500, 0}, 60), Seen::kHidden);
  EXPECT_EQ(table.look({5950, 3000}, 60), Seen::kMet) << "the wall";
  EXPECT_EQ(table.look({7000, 3000}, 60), Seen::kHidden) << "behind the wall";
  EXPECT_NEAR(table.towards(1, 0).met, 2800, 60);
}

TEST(FreeTable, APlaceIsAsWideAsItIs) {
  Room world;
  const FreeTable table = table_of(world.scan({{{3000, 0}, 100}}));
  EXPECT_EQ(table.look({2950, 220}, 30), Seen::kThrough);
  EXPECT_EQ(table.look({2950, 220}, 160), Seen::kMet);
}

// A leg between two beams: neither of them shows the place as free.
TEST(FreeTable, BeamsBesideAThingKnowNothingOfIt) {
  Room world;
  const FreeTable table = table_of(world.scan({{{3000, 0}, 100}}));
  EXPECT_EQ(table.look({4500, 160}, 10), Seen::kHidden);
  EXPECT_EQ(table.look({4500, 400}, 10), Seen::kThrough);
}

TEST(FreeTable, WhereNoBeamGoesNothingIsKnown) {
  Room world;
  Scan2dData scan = world.scan({});
  std::erase_if(scan.points, [](const ScanPoint& point) { return point.x < 0; });
  const FreeTable table = table_of(scan);
  EXPECT_EQ(table.look({2000, 1000}, 60), Seen::kThrough);
  EXPECT_EQ(table.look({-2000, 1000}, 60), Seen::kHidden);
  EXPECT_EQ(FreeTable{}.look({2000, 0}, 60), Seen::kHidden);
}

TEST(FreeTable, FromWhereTheRobotIs) {
  Room world;
  const Pose robot{.x = 2000, .y = -1000, .rho = radians(120)};
  const FreeTable table = table_of(world.scan({{{2000, 2000}, 200}}, robot), robot);
  EXPECT_EQ(table.from().x, 2000);
  EXPECT_EQ(table.look({2000, 1800}, 60), Seen::kMet);
  EXPECT_EQ(table.look({2000, 500}, 60), Seen::kThrough);
  EXPECT_EQ(table.look({2000, -1000}, 60), Seen::kThrough) << "the robot itself";
}

}  // namespace free_table_test
}  // namespace rack::perception
