#include "components/path/rddf.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/path/route_fixture.h"

namespace rack::path {
namespace rddf_test {

TEST(Rddf, ReadsTheRouteOf2004) {
  const auto points = read_rddf(route_file("dgc2004-rddf.txt"));
  ASSERT_TRUE(points.ok());
  ASSERT_EQ(points->size(), 2586U);
  EXPECT_EQ(points->front().number, 1);
  EXPECT_NEAR(degrees(points->front().latitude), 34.7607233, 1e-9);
  EXPECT_NEAR(degrees(points->front().longitude), -117.0107599, 1e-9);
  EXPECT_NEAR(points->front().offset, 90 * 304.8, 1e-6);
  EXPECT_NEAR(points->front().speed, 4470.4, 1e-6);
  EXPECT_EQ(points->back().speed, 0);
}

TEST(Rddf, ReadsWhatATeamWroteByHand) {
  const auto points = read_rddf(route_file("sunlot-rddf.txt"));
  ASSERT_TRUE(points.ok());
  EXPECT_EQ(points->size(), 17U);
}

TEST(Rddf, MeasuresInDouble) {
  const auto waypoints = route("dgc2004-rddf.txt");
  ASSERT_TRUE(waypoints.ok());
  double length = 0;
  for (std::size_t i = 1; i < waypoints->size(); ++i)
    length += std::hypot((*waypoints)[i].x - (*waypoints)[i - 1].x,
                         (*waypoints)[i].y - (*waypoints)[i - 1].y);
  EXPECT_NEAR(length / 1e6, 228.9, 0.2);
}

TEST(Rddf, LimitsOfTheLegAfterAPointBelongToTheNextWaypoint) {
  const auto points =
      read_rddf("1,50,10,10,20\n2,50.001,10,30,40\r\n\n# end\n3,50.002,10,5,0,#,#,#");
  ASSERT_TRUE(points.ok());
  navigation::Coordinates world({.reference = navigation::PositionReference::kUtm}, true);
  const auto waypoints =
      to_waypoints(*points, [&](const PositionWgs84Data& at) { return world.from(at); });
  ASSERT_TRUE(waypoints.ok());
  EXPECT_EQ((*waypoints)[1].speed, 8940);
  EXPECT_EQ((*waypoints)[1].lbo, 3048);
  EXPECT_EQ((*waypoints)[2].speed, 17881);
  EXPECT_EQ((*waypoints)[2].id, 3);
}

TEST(Rddf, ReportsTheMalformedLine) {
  for (const char* line : {"x", "1,2,3,4", "1,91,10,10,20", "1,50,181,10,20", "1,50,10,-1,20",
                           "1,50,10,10,1e9", "1,nan,10,10,20", "1,50,inf,10,20", "1,50,10,10,nan",
                           "1,50 1,10,10,20", "1,50,10,10,20,#,#,#,#", "1,,10,10,20"}) {
    const auto points = read_rddf(std::string("1,50,10,10,20\n") + line);
    ASSERT_FALSE(points.ok()) << line;
    EXPECT_EQ(points.error().code(), tims::Errc::kMalformed);
    EXPECT_NE(points.error().detail().find("line 2"), std::string::npos) << line;
  }
}

TEST(Rddf, BoundsHowManyThereAre) {
  std::string text;
  for (std::size_t i = 0; i < kWaypointsMax; ++i) text += "1,50,10,10,20\n";
  EXPECT_TRUE(read_rddf(text).ok());
  text += "1,50,10,10,20\n";
  const auto points = read_rddf(text);
  ASSERT_FALSE(points.ok());
  EXPECT_EQ(points.error().code(), tims::Errc::kTooBig);
}

TEST(Rddf, RefusesAStopBeforeTheLastPoint) {
  const auto points = read_rddf("1,50,10,10,20\n2,50.001,10,30,0\n3,50.002,10,5,0");
  ASSERT_TRUE(points.ok());
  const auto waypoints = to_waypoints(
      *points,
      [](const PositionWgs84Data&) -> tims::Result<PositionData> { return PositionData{}; });
  ASSERT_FALSE(waypoints.ok());
  EXPECT_NE(waypoints.error().detail().find("waypoint 3"), std::string::npos);
}

TEST(Rddf, RefusesWaypointsTooFarAway) {
  const auto points = read_rddf("1,50,10,10,20\n");
  ASSERT_TRUE(points.ok());
  PositionData far;
  far.pos.x = std::numeric_limits<i32>::max();
  const auto waypoints = to_waypoints(
      *points, [&](const PositionWgs84Data&) -> tims::Result<PositionData> { return far; });
  ASSERT_FALSE(waypoints.ok());
  EXPECT_NE(waypoints.error().detail().find("autoOffset"), std::string::npos);
}

}  // namespace rddf_test
}  // namespace rack::path
