#include "components/path/path_maker.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/path/route_fixture.h"

namespace rack::path {
namespace path_maker_test {

constexpr double kRounding = 3;  // mm, of messages

Waypoint2d waypoint(i32 x, i32 y, i32 speed = 0, i32 lbo = 0) {
  Waypoint2d point;
  point.x = x;
  point.y = y;
  point.speed = speed;
  point.lbo = lbo;
  return point;
}

using Path = std::vector<PolarSpline>;

// Properties of every path: it is continuous, and stays within the corridor and all limits.
void expect_good(const Path& path, const std::vector<Waypoint2d>& route, const PathLimits& limits,
                 std::size_t neighbours = 1000000) {
  ASSERT_FALSE(path.empty());
  ASSERT_LE(path.size(), kSplinesMax);
  std::size_t near = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const PolarSpline& spline = path[i];
    SCOPED_TRACE("spline " + std::to_string(i));
    const double most = limits.speed_max;
    EXPECT_LE(spline.vMax, most);
    if (spline.radius != 0) {
      const double radius = std::abs(static_cast<double>(spline.radius));
      EXPECT_GE(radius, limits.radius_min);
      EXPECT_LE(spline.vMax / radius, limits.omega_max + 1 / radius);
      EXPECT_LE(1.0 * spline.vMax * spline.vMax / radius, limits.lateral_acceleration + 1);
    }
    EXPECT_LE(spline.vStart, spline.vMax);
    EXPECT_LE(spline.vEnd, spline.vMax);
    const double grows = 1.0 * spline.vEnd * spline.vEnd - 1.0 * spline.vStart * spline.vStart;
    EXPECT_LE(grows, 2 * limits.acceleration * size(spline) + 1);
    EXPECT_LE(-grows, 2 * limits.deceleration * size(spline) + 1);
    for (int part = 0; part <= 8; ++part) {
      const Pose at = pose_at(spline, spline.length * part / 8.0);
      double out = outside(at.x, at.y, route, limits, near, neighbours);
      while (out > kRounding - limits.half_width && near + neighbours < route.size())
        out = outside(at.x, at.y, route, limits, ++near, neighbours);
      ASSERT_LE(out, kRounding - limits.half_width);
    }
    if (i + 1 == path.size()) break;
    const Pose end = pose_at(spline, spline.length);
    const Pose next = pose_at(path[i + 1], 0);
    EXPECT_LE(std::hypot(end.x - next.x, end.y - next.y), kRounding);
    if (runs_on(spline, path[i + 1])) {
      EXPECT_EQ(spline.vEnd, path[i + 1].vStart);
    } else {
      EXPECT_EQ(spline.vEnd, 0);
      EXPECT_EQ(path[i + 1].vStart, 0);
    }
  }
  EXPECT_EQ(path.front().vStart, 0);
  EXPECT_EQ(path.back().vEnd, 0);
  const Pose end = pose_at(path.back(), path.back().length);
  EXPECT_LE(std::hypot(end.x - route.back().x, end.y - route.back().y), 12);
}

TEST(PathMaker, RoundsACorner) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(10000, 0, 1000, 1000),
                                         waypoint(10000, 10000, 500, 1000)};
  const PathLimits limits{.omega_max = 0.5};
  const auto path = make_path(route, limits);
  ASSERT_TRUE(path.ok());
  ASSERT_EQ(path->size(), 3U);
  EXPECT_EQ((*path)[0].radius, 0);
  EXPECT_EQ((*path)[1].radius, 2000) << "twice what 500 mm/s need";
  EXPECT_EQ((*path)[1].length, 3142);
  EXPECT_EQ((*path)[1].centerPos.x, 8000);
  EXPECT_EQ((*path)[1].centerPos.y, 2000);
  EXPECT_EQ((*path)[0].vMax, 1000);
  EXPECT_EQ((*path)[1].vMax, 500);
  EXPECT_EQ((*path)[0].vEnd, 500);
  expect_good(*path, route, limits);
}

TEST(PathMaker, DrivesTheRouteOf2004) {
  const auto route = path::route("dgc2004-rddf.txt");
  ASSERT_TRUE(route.ok());
  const PathLimits limits{.speed_max = 15000,
                          .acceleration = 2000,
                          .deceleration = 3000,
                          .omega_max = 1,
                          .lateral_acceleration = 3000,
                          .half_width = 1000};
  const auto path = make_path(*route, limits);
  ASSERT_TRUE(path.ok()) << path.error().detail();
  EXPECT_NEAR(static_cast<double>(path->size()), 5171, 150);
  expect_good(*path, *route, limits, 2);
}

TEST(PathMaker, DrivesTheCoursesForTrying) {
  for (const char* name : {"dgc2004-speedway-rddf.txt", "sunlot-rddf.txt"}) {
    SCOPED_TRACE(name);
    const auto route = path::route(name);
    ASSERT_TRUE(route.ok());
    const PathLimits limits{
        .speed_max = 4000, .omega_max = 0.8, .radius_min = 3000, .half_width = 700};
    const auto path = make_path(*route, limits);
    ASSERT_TRUE(path.ok()) << path.error().detail();
    expect_good(*path, *route, limits);
  }
}

TEST(PathMaker, GoesBackwardWhereTheInterfaceRequiresIt) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0, 1), waypoint(5000, 0, 1),
                                         waypoint(2000, 0, -1), waypoint(2000, 3000, -1)};
  const PathLimits limits{.backward_max = 400};
  const auto path = make_path(route, limits);
  ASSERT_TRUE(path.ok());
  expect_good(*path, route, limits);
  EXPECT_GT(path->front().length, 0);
  EXPECT_EQ(path->front().vMax, 1000);
  EXPECT_LT(path->back().length, 0);
  EXPECT_EQ(path->back().vMax, 400);
  EXPECT_NEAR(signed_angle(path->back().startPos.rho), -kPi / 2, 1e-6);
}

TEST(PathMaker, LeadsIntoALegThatBeginsWithAnotherHeading) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0, 1), waypoint(5000, 0, 1, 3000),
                                         waypoint(1000, 1000, -1, 3000)};
  const PathLimits limits{.radius_min = 1000};
  const auto path = make_path(route, limits);
  ASSERT_TRUE(path.ok());
  expect_good(*path, route, limits);
  ASSERT_EQ(path->size(), 3U);
  EXPECT_NE((*path)[1].radius, 0);
  const double east = kPi / 2;
  const auto turned = make_path(std::span(route).first(2), limits, &east);
  ASSERT_TRUE(turned.ok());
  EXPECT_NEAR(turned->front().startPos.rho, east, 1e-6);
  EXPECT_LT(turned->front().radius, 0);
}

TEST(PathMaker, ReportsWhereTheVehicleCannotTurn) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(3000, 0), waypoint(3000, 3000)};
  const auto path = make_path(route, {.radius_min = 5000});
  ASSERT_FALSE(path.ok());
  EXPECT_NE(path.error().detail().find("(3000, 0)"), std::string::npos) << path.error().detail();
  EXPECT_TRUE(make_path(route, {.radius_min = 1000}).ok());
  // Back on the same line: only a vehicle that turns at rest can do it, and it stops.
  const std::vector<Waypoint2d> back = {waypoint(0, 0), waypoint(3000, 0), waypoint(0, 0)};
  EXPECT_FALSE(make_path(back, {.radius_min = 100}).ok());
  const auto turning = make_path(back, {});
  ASSERT_TRUE(turning.ok());
  EXPECT_EQ(turning->front().vEnd, 0);
}

TEST(PathMaker, RefusesHostileRoutes) {
  const PathLimits limits;
  EXPECT_FALSE(make_path({}, limits).ok());
  std::vector<Waypoint2d> route = {waypoint(0, 0)};
  EXPECT_FALSE(make_path(route, limits).ok());
  route.assign(5, waypoint(7, 7));
  EXPECT_FALSE(make_path(route, limits).ok()) << "one place";
  route.assign(6001, waypoint(7, 7));
  EXPECT_EQ(make_path(route, limits).error().code(), tims::Errc::kTooBig);
  route = {waypoint(std::numeric_limits<i32>::min(), 0),
           waypoint(std::numeric_limits<i32>::max(), 0)};
  EXPECT_FALSE(make_path(route, limits).ok()) << "4000 km";
  route = {waypoint(0, 0), waypoint(5000, 0, 1000, 100)};
  EXPECT_FALSE(make_path(route, {.half_width = 300}).ok()) << "too narrow";
  // 4000 corners: more splines than fit.
  route.clear();
  for (i32 i = 0; i < 4000; ++i) route.push_back(waypoint(i * 5000, i % 2 * 5000));
  EXPECT_EQ(make_path(route, limits).error().code(), tims::Errc::kTooBig);
}

TEST(PathMaker, RefusesLimitsThatAreNone) {
  const std::vector<Waypoint2d> route = {waypoint(0, 0), waypoint(5000, 0)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -1.0, 0.0}) {
    EXPECT_FALSE(make_path(route, {.speed_max = bad}).ok()) << bad;
    EXPECT_FALSE(make_path(route, {.deceleration = bad}).ok()) << bad;
    EXPECT_FALSE(make_path(route, {.omega_max = bad}).ok()) << bad;
    EXPECT_FALSE(make_path(route, {.lateral_acceleration = bad}).ok()) << bad;
  }
  EXPECT_FALSE(make_path(route, {.radius_min = nan}).ok());
}

// Random walks that cross themselves, with legs of no length, hairpins, and both senses.
TEST(PathMaker, KeepsItsPromisesOnAnyRoute) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> any(0, 1);
  int made = 0;
  for (int round = 0; round < 2000; ++round) {
    PathLimits limits{.speed_max = 200 + 5000 * any(random),
                      .acceleration = 100 + 2000 * any(random),
                      .deceleration = 100 + 2000 * any(random),
                      .omega_max = 0.2 + any(random),
                      .lateral_acceleration = 300 + 3000 * any(random),
                      .radius_min = any(random) < 0.5 ? 0 : 1000 * any(random),
                      .half_width = 300 * any(random)};
    limits.backward_max = std::min(limits.backward_max, limits.speed_max);
    std::vector<Waypoint2d> route;
    double x = 0;
    double y = 0;
    double heading = 0;
    const bool backs = any(random) < 0.3;
    const auto count = static_cast<int>(2 + 40 * any(random));
    for (int i = 0; i < count; ++i) {
      heading += (any(random) - 0.5) * 3 * any(random);
      const double length = any(random) < 0.1 ? 0 : 20000 * any(random) * any(random);
      x += length * std::cos(heading);
      y += length * std::sin(heading);
      const double speed = 5000 * any(random) * (backs && any(random) < 0.3 ? -1 : 1);
      route.push_back(waypoint(whole_millimetres(x), whole_millimetres(y), static_cast<i32>(speed),
                               any(random) < 0.2 ? 0 : static_cast<i32>(350 + 3000 * any(random))));
    }
    const auto path = make_path(route, limits);
    if (!path) {
      EXPECT_FALSE(path.error().detail().empty());
      continue;
    }
    ++made;
    SCOPED_TRACE("round " + std::to_string(round));
    expect_good(*path, route, limits);
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(made, 500);
}

}  // namespace path_maker_test
}  // namespace rack::path
