#include "components/perception/scan_merger.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/counted_new.h"

namespace rack::perception {
namespace scan_merger_test {

Scan2dData scan(u32 time, std::vector<ScanPoint> points) {
  Scan2dData data{.recordingTime = time, .duration = 20, .maxRange = 20000};
  data.points.assign(points.begin(), points.end());
  return data;
}

Pose at(double x, double y, double degrees = 0) {
  return {.x = x, .y = y, .rho = radians(degrees)};
}

TEST(ScanMerger, EachScanIsMovedByTheOdometryOfItsOwnTime) {
  ScanMerger merger;
  // The same pole at x = 5000, seen from two places.
  ASSERT_TRUE(merger.take(0, scan(1000, {{.x = 4000, .y = 0}}), at(1000, 0)));
  ASSERT_TRUE(merger.take(1, scan(1050, {{.x = 0, .y = -3000}}), at(2000, 0, 90)));
  Scan2dData merged;
  ASSERT_TRUE(merger.merge(1100, at(3000, 0), merged));
  EXPECT_EQ(merged.recordingTime, TimeStamp(1100));
  EXPECT_EQ(merged.duration, 120U) << "since the older one began";
  ASSERT_EQ(merged.points.size(), 2U);
  for (const ScanPoint& point : merged.points) {
    EXPECT_EQ(point.x, 2000);
    EXPECT_EQ(point.y, 0);
    EXPECT_EQ(point.z, 2000);
  }
}

TEST(ScanMerger, SortedByAngleAndDistinguished) {
  ScanMerger merger;
  merger.take(0, scan(0, {{.x = 0, .y = -1000}, {.x = 1000, .y = 0, .type = 0x80}}), at(0, 0));
  merger.take(3, scan(0, {{.x = -1000, .y = 10}, {.x = 500, .y = -500}}), at(0, 0));
  Scan2dData merged;
  ASSERT_TRUE(merger.merge(0, at(0, 0), merged));
  std::vector<int> segments;
  for (const ScanPoint& point : merged.points) segments.push_back(point.segment);
  EXPECT_EQ(segments, (std::vector<int>{1, 4, 1, 4}));
  EXPECT_EQ(merged.points[2].type, 0x80);
  EXPECT_EQ(merged.sectorNum, 1);
}

TEST(ScanMerger, OneThatStaysAwayIsLeftOut) {
  ScanMerger merger;
  Scan2dData merged;
  EXPECT_FALSE(merger.merge(0, at(0, 0), merged));
  merger.take(0, scan(0, {{.x = 1000}}), at(0, 0));
  merger.take(1, scan(0, {{.x = 2000}}), at(0, 0));
  merger.forget(0);
  merger.forget(99);
  ASSERT_TRUE(merger.merge(0, at(0, 0), merged));
  ASSERT_EQ(merged.points.size(), 1U);
  EXPECT_EQ(merged.points[0].x, 2000);
}

TEST(ScanMerger, SectorsAreKeptEach) {
  ScanMerger merger;
  const auto sector = [&](i32 index, i32 x) {
    Scan2dData data = scan(0, {{.x = x}, {.x = x}});
    data.sectorNum = 3;
    data.sectorIndex = index;
    return merger.take(0, data, at(0, 0));
  };
  ASSERT_TRUE(sector(0, 1000));
  ASSERT_TRUE(sector(1, 2000));
  ASSERT_TRUE(sector(0, 3000));
  Scan2dData merged;
  ASSERT_TRUE(merger.merge(0, at(0, 0), merged));
  EXPECT_EQ(merged.points.size(), 4U);
  EXPECT_EQ(std::ranges::count_if(merged.points, [](auto& p) { return p.x == 1000; }), 0);
}

TEST(ScanMerger, NoMorePointsThanAMessageHas) {
  ScanMerger merger;
  for (std::size_t source = 0; source < 2; ++source) {
    Scan2dData data = scan(0, {});
    for (int i = 0; i < 8000; ++i) {
      const double angle = radians(i * 360.0 / 8000);
      data.points.push_back({.x = whole_millimetres(5000 * std::cos(angle)),
                             .y = whole_millimetres(5000 * std::sin(angle))});
    }
    ASSERT_TRUE(merger.take(source, data, at(0, 0)));
  }
  Scan2dData merged;
  reserve_all(merged);
  const std::uint64_t before = tims::test::allocations();
  ASSERT_TRUE(merger.merge(0, at(0, 0), merged));
  EXPECT_EQ(tims::test::allocations(), before);
  EXPECT_EQ(merged.points.size(), 8000U);
  EXPECT_EQ(merger.left_out(), 8000U);
  EXPECT_LT(merged.points.front().y, 0) << "all around";
  EXPECT_GT(merged.points[7000].y, 0);
}

TEST(ScanMerger, WhatIsOldOrNoPoseIsRefused) {
  ScanMerger merger;
  EXPECT_TRUE(merger.take(0, scan(100, {{.x = 1}}), at(0, 0)));
  EXPECT_FALSE(merger.take(0, scan(99, {{.x = 2}}), at(0, 0)));
  EXPECT_FALSE(merger.take(4, scan(200, {}), at(0, 0)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(merger.take(0, scan(200, {}), at(nan, 0)));
  Scan2dData merged;
  EXPECT_FALSE(merger.merge(0, at(0, nan), merged));
  ASSERT_TRUE(merger.take(0, scan(200, {}), at(0, 0)));
  ASSERT_TRUE(merger.merge(0, at(0, 0), merged));
  EXPECT_TRUE(merged.points.empty());
}

TEST(ScanMerger, TimeStampsWrap) {
  ScanMerger merger;
  ASSERT_TRUE(merger.take(0, scan(0xFFFFFFF0U, {{.x = 1}}), at(0, 0)));
  EXPECT_TRUE(merger.take(0, scan(0x10U, {{.x = 2}}), at(0, 0)));
}

}  // namespace scan_merger_test
}  // namespace rack::perception
