#include "components/scan2d/ladar_scan.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::scan2d {
namespace ladar_scan_test {

LadarPoint point(double degrees, i32 distance, i32 type = 0) {
  return {.angle = static_cast<f32>(radians(degrees)), .distance = distance, .type = type};
}

Scan2dData converted(const std::vector<LadarPoint>& points, const LadarMounting& mounting = {},
                     const ScanFilter& filter = {}) {
  LadarData ladar{.recordingTime = 5, .duration = 20, .maxRange = 20000};
  ladar.points.assign(points.begin(), points.end());
  Scan2dData scan;
  convert(ladar, mounting, filter, scan);
  return scan;
}

TEST(LadarScan, BecomesPoints) {
  const Scan2dData scan = converted({point(0, 1000), point(90, 500), point(-90, 2000)});
  EXPECT_EQ(scan.recordingTime, TimeStamp(5));
  EXPECT_EQ(scan.duration, 20U);
  EXPECT_EQ(scan.maxRange, 20000);
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_EQ(scan.points[0].x, 1000);
  EXPECT_EQ(scan.points[1].y, 500);
  EXPECT_EQ(scan.points[2].y, -2000);
  EXPECT_EQ(scan.points[2].z, 2000);
}

TEST(LadarScan, WhereTheLadarIs) {
  const Scan2dData scan =
      converted({point(0, 1000), point(90, 500)}, {.x = 100, .y = -20, .rho = radians(90)});
  EXPECT_EQ(scan.points[0].x, 100);
  EXPECT_EQ(scan.points[0].y, 980);
  EXPECT_EQ(scan.points[1].x, -400);
  EXPECT_EQ(converted({point(90, 500)}, {.upside_down = true}).points[0].y, -500);
}

// A round wall at 10 m around where the robot is in the middle of the scan, seen while it turns and
// goes: farthest off the wall's place, mm.
double bent(const Pose& motion, bool reversed, const Pose& reported) {
  constexpr int kPoints = 361;
  const LadarMounting mounting{.x = 300, .y = -50, .rho = 0.1, .is_reversed = reversed};
  LadarData ladar{.duration = 100, .maxRange = 30000};
  std::vector<Pose> truth;
  for (int i = 0; i < kPoints; ++i) {
    const double after = (i / (kPoints - 1.0) - 0.5) * (reversed ? -1 : 1);
    const Pose at = Pose{.x = after * motion.x, .y = after * motion.y, .rho = after * motion.rho} +
                    Pose{.x = 300, .y = -50, .rho = 0.1};
    const LadarPoint seen = point(i / 2.0 - 90, 10000);
    ladar.points.push_back(seen);
    truth.push_back(at +
                    Pose{.x = 10000 * std::cos(seen.angle), .y = 10000 * std::sin(seen.angle)});
  }
  Scan2dData scan;
  convert(ladar, mounting, {}, scan, reported);
  double most = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    most = std::max(most, std::hypot(scan.points[i].x - truth[i].x, scan.points[i].y - truth[i].y));
  return most;
}

TEST(LadarScan, IsCorrectedByTheMotion) {
  // 1 rad/s and 1 m/s at 10 Hz; and 4 m/s at 75 Hz.
  for (const bool reversed : {false, true}) {
    const Pose turning{.x = 100, .y = 0, .rho = 0.1};
    EXPECT_GT(bent(turning, reversed, {}), 450);
    EXPECT_LT(bent(turning, reversed, turning), 1);
    const Pose going{.x = 27, .y = 0, .rho = 0};
    EXPECT_GT(bent(going, reversed, {}), 13);
    EXPECT_LT(bent(going, reversed, going), 1);
  }
}

TEST(LadarScan, TheMotionIsThatOfItsDuration) {
  const Pose before{.x = 1000, .y = 1000, .rho = radians(359)};
  const Pose now = before + Pose{.x = 100, .y = 10, .rho = radians(4)};
  const Pose motion = motion_during_scan(before, now, 50, 25);
  EXPECT_NEAR(motion.x, 50, 1e-6);
  EXPECT_NEAR(motion.y, 5, 1e-6);
  EXPECT_NEAR(motion.rho, radians(2), 1e-6) << "by the smaller angle";
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Pose& none :
       {motion_during_scan(before, now, 0, 25), motion_during_scan(before, now, -50, 25),
        motion_during_scan(before, now, 50, 4e9), motion_during_scan(before, {.x = 1e6}, 50, 25),
        motion_during_scan(before, {.x = kNan}, 50, 25), motion_during_scan(before, now, 50, kNan)})
    EXPECT_EQ(none.x, 0);
}

TEST(LadarScan, WhatIsTooFarOrNothing) {
  const Scan2dData scan = converted({point(0, 5000), point(0, 4999), point(0, 0), point(0, -7)}, {},
                                    {.range_max = 5000});
  EXPECT_EQ(scan.maxRange, 5000);
  EXPECT_EQ(scan.points[0].type, 0x30);
  EXPECT_EQ(scan.points[1].type, 0);
  EXPECT_EQ(scan.points[2].type, 0x30);
  EXPECT_EQ(scan.points[2].z, 5000);
  EXPECT_EQ(scan.points[3].type, 0x30);
}

TEST(LadarScan, Types) {
  const Scan2dData scan =
      converted({point(0, 1, ladar_point::kRain), point(0, 1, ladar_point::kDirt),
                 point(0, 1, ladar_point::kTransparent), point(0, 1, ladar_point::kInvalid),
                 point(0, 1, ladar_point::kReflector)});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(scan.points[static_cast<std::size_t>(i)].type, 0x10);
  EXPECT_EQ(scan.points[4].type, 0x80);
}

TEST(LadarScan, ReducedAndCut) {
  std::vector<LadarPoint> points;
  for (int i = -180; i <= 180; ++i) points.push_back(point(i, 1000));
  EXPECT_EQ(converted(points).points.size(), 361U);
  EXPECT_EQ(converted(points, {}, {.reduce = 2}).points.size(), 181U);
  EXPECT_EQ(converted(points, {}, {.angle_min = radians(-90.5), .angle_max = radians(90.5)})
                .points.size(),
            181U);
  points = {point(std::numeric_limits<double>::quiet_NaN(), 1000)};
  EXPECT_TRUE(converted(points).points.empty());
}

TEST(LadarScan, TheMedianTakesOutWhatSticksOut) {
  const std::vector<LadarPoint> points = {point(0, 100), point(1, 9000), point(2, 102),
                                          point(3, 101), point(4, 5)};
  const Scan2dData scan = converted(points, {}, {.median = true});
  EXPECT_EQ(scan.points[0].z, 100);
  EXPECT_EQ(scan.points[1].z, 102);
  EXPECT_EQ(scan.points[2].z, 102);
  EXPECT_EQ(scan.points[3].z, 101);
  EXPECT_EQ(scan.points[4].z, 5) << "the ends have one neighbour only";
}

// What makes pilots brake: a single ray that comes back from rain or dust. A post that two rays
// meet is one.
TEST(LadarScan, TheMedianTakesOutALoneShortRayAndLeavesAPost) {
  for (const int rays : {1, 2}) {
    std::vector<LadarPoint> points;
    for (int i = -90; i <= 90; ++i) {
      const bool is_short = i >= 10 && i < 10 + rays;
      points.push_back(point(i, is_short ? 300 : 4000));
    }
    const auto nearest = [&](bool median) {
      const Scan2dData scan = converted(points, {}, {.median = median});
      return std::ranges::min_element(scan.points, {}, &ScanPoint::z)->z;
    };
    EXPECT_EQ(nearest(false), 300);
    EXPECT_EQ(nearest(true), rays == 1 ? 4000 : 300);
  }
}

TEST(LadarScan, TheMedianLeavesReflectorsAlone) {
  const std::vector<LadarPoint> points = {point(0, 100), point(1, 900, ladar_point::kReflector),
                                          point(2, 102), point(3, 800),
                                          point(4, 104), point(5, 0),
                                          point(6, 106)};
  const Scan2dData scan = converted(points, {}, {.median = true});
  EXPECT_EQ(scan.points[1].z, 900);
  EXPECT_EQ(scan.points[2].z, 102) << "beside one";
  EXPECT_EQ(scan.points[3].z, 104);
  EXPECT_EQ(scan.points[4].z, 104) << "beside no measurement";
  EXPECT_EQ(scan.points[5].type, 0x30);
}

TEST(LadarScan, UpsideDownItsLimitsAreMirroredToo) {
  const std::vector<LadarPoint> points = {point(-90, 1), point(-30, 2), point(0, 3), point(60, 4)};
  const Scan2dData scan = converted(points, {.upside_down = true},
                                    {.angle_min = radians(-70), .angle_max = radians(40)});
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_EQ(scan.points[0].z, 4) << "in the order of their angles";
  EXPECT_EQ(scan.points[1].z, 3);
  EXPECT_EQ(scan.points[2].z, 2);
  EXPECT_EQ(converted(points, {.upside_down = true}, {.reduce = 3}).points[0].z, 4);
}

// A wall 2 m ahead, from -30 to 30 degrees, its direction turned by `slant` degrees.
std::vector<LadarPoint> wall(double slant) {
  std::vector<LadarPoint> points;
  for (int i = -30; i <= 30; ++i)
    points.push_back(
        point(i, static_cast<i32>(2000 * std::cos(radians(slant)) / std::cos(radians(i - slant)))));
  return points;
}

TEST(LadarScan, AWallSeenAtRightAnglesIsNoReflector) {
  const auto type = [](double slant, std::initializer_list<std::size_t> shining, std::size_t of,
                       const LadarMounting& mounting = {}, bool filtered = true) {
    std::vector<LadarPoint> points = wall(slant);
    for (const std::size_t i : shining) points[i].type = ladar_point::kReflector;
    return converted(points, mounting, {.reflectors = filtered}).points[of].type;
  };
  EXPECT_EQ(type(0, {30}, 30), 0);
  EXPECT_EQ(type(0, {30}, 30, {}, false), 0x80);
  EXPECT_EQ(type(14, {30}, 30), 0);
  EXPECT_EQ(type(16, {30}, 30), 0x80) << "seen from aside";
  EXPECT_EQ(type(0, {30}, 30, {.x = 100, .y = -200, .rho = radians(120)}), 0);
  EXPECT_EQ(type(16, {30}, 30, {.x = 100, .y = -200, .rho = radians(120)}), 0x80);
  EXPECT_EQ(type(0, {30, 31}, 30), 0);
  for (const std::size_t i : {29U, 30U, 31U}) EXPECT_EQ(type(0, {29, 30, 31}, i), 0x80) << i;
  std::vector<LadarPoint> alone = {point(-20, 2000), point(0, 2000, ladar_point::kReflector)};
  EXPECT_EQ(converted(alone, {}, {.reflectors = true}).points[1].type, 0x80) << "on no wall";
}

TEST(Intensities, OfTheSameScan) {
  Scan2dData scan = converted({point(0, 1000), point(1, 1000)});
  CameraData camera{
      .recordingTime = 5, .width = 1, .height = 2, .depth = 16, .mode = camera_mode::kMono16};
  camera.image = {std::byte{0x01}, std::byte{0x02}, std::byte{0x7F}, std::byte{0xFF}};
  ASSERT_TRUE(add_intensities(camera, scan));
  EXPECT_EQ(scan.points[0].intensity, 0x0102);
  EXPECT_EQ(scan.points[1].intensity, 0x7FFF);
  CameraData wrong = camera;
  wrong.recordingTime = 6;
  EXPECT_FALSE(add_intensities(wrong, scan));
  wrong = camera;
  wrong.mode = camera_mode::kMono8;
  EXPECT_FALSE(add_intensities(wrong, scan));
  wrong = camera;
  wrong.width = wrong.height = 2;
  EXPECT_FALSE(add_intensities(wrong, scan));
  wrong = camera;
  wrong.image.resize(2);
  EXPECT_FALSE(add_intensities(wrong, scan));
}

}  // namespace ladar_scan_test
}  // namespace rack::scan2d
