#include "components/perception/scan_view.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace rack::perception {
namespace scan_view_test {

Scan2dData fan(int from, int to, i32 range) {
  Scan2dData scan;
  for (int degree = from; degree <= to; ++degree)
    scan.points.push_back({.x = whole_millimetres(range * std::cos(radians(degree))),
                           .y = whole_millimetres(range * std::sin(radians(degree)))});
  return scan;
}

TEST(ScanView, PlacesAsTheRobotStands) {
  Scan2dData scan = fan(0, 0, 1000);
  ScanView view;
  view.take(scan, {.x = 200}, 5000);
  EXPECT_NEAR(view.sights().at(0).away, 800, 1) << "from the scanner";
  view.place({.x = 1000, .y = 500, .rho = radians(90)});
  EXPECT_NEAR(view.sights()[0].x, 1000, 1);
  EXPECT_NEAR(view.sights()[0].y, 1500, 1);
  EXPECT_NEAR(view.scanner().y, 700, 1);
}

TEST(ScanView, WhatIsNoMeasurement) {
  Scan2dData scan = fan(0, 3, 1000);
  scan.points[0].type = scan_point::kInvalid;
  scan.points[1].type = scan_point::kInvalid | scan_point::kMaxRange;
  scan.points[2].x = scan.points[2].y = 0;
  ScanView view;
  view.take(scan, {}, 900);
  ASSERT_EQ(view.sights().size(), 2U);
  EXPECT_FALSE(view.sights()[0].hit) << "it saw nothing";
  EXPECT_FALSE(view.sights()[1].hit) << "farther than is looked";
  EXPECT_NEAR(view.sights()[1].away, 900, 1);
}

TEST(ScanView, SortedAndMeasured) {
  Scan2dData scan = fan(-90, 90, 1000);
  std::ranges::reverse(scan.points);
  ScanView view;
  view.take(scan, {}, 5000);
  EXPECT_LT(view.sights().front().y, 0);
  EXPECT_NEAR(view.resolution(), radians(1), 1e-3);
  EXPECT_FALSE(view.full_turn());
  view.take(fan(-180, 179, 1000), {}, 5000);
  EXPECT_TRUE(view.full_turn());
  view.take({}, {}, 5000);
  EXPECT_TRUE(view.sights().empty());
}

}  // namespace scan_view_test
}  // namespace rack::perception
