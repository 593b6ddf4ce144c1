#include "components/path/seen_obstacles.h"

#include <cmath>

#include <gtest/gtest.h>

namespace rack::path {
namespace seen_obstacles_test {

// A room of 8 m, empty but for one wall at x = 3 m.
class SeenObstaclesTest : public testing::Test {
 protected:
  SeenObstaclesTest() : space_(FreeSpace::empty({-4000, -4000}, 8000, 8000, 50).value()) {
    space_.occupy({3000, -1000}, {3000, 1000});
    space_.measure();
  }

  static ScanPoint echo(int x, int y, int type = 0) { return {.x = x, .y = y, .type = type}; }
  std::size_t marks_after(std::initializer_list<ScanPoint> points, const Pose& from = {}) {
    Scan2dData scan;
    for (const ScanPoint& point : points) scan.points.push_back(point);
    seen_.take(scan, from);
    seen_.update(space_, &space_);
    return seen_.marks().size();
  }

  FreeSpace space_;
  SeenObstacles seen_;
};

TEST_F(SeenObstaclesTest, MarksWhatTheMapDoesNotExplain) {
  EXPECT_EQ(marks_after({echo(2900, 0)}), 0U) << "the wall";
  EXPECT_EQ(marks_after({echo(9000, 0)}), 0U) << "outside of the map";
  EXPECT_EQ(marks_after({echo(1000, 0, scan_point::kInvalid)}), 0U);
  EXPECT_EQ(marks_after({echo(1000, 0, 1)}), 0U) << "a landmark";
  ASSERT_EQ(marks_after({echo(1000, 0)}, {.x = 100, .y = 0, .rho = kPi / 2}), 1U);
  EXPECT_NEAR(seen_.marks()[0].x, 100, 1e-6);
  EXPECT_NEAR(seen_.marks()[0].y, 1000, 1e-6);
}

TEST_F(SeenObstaclesTest, AMarkGoesWhenTheScannerLooksThroughIt) {
  ASSERT_EQ(marks_after({echo(1000, 0)}), 1U);
  EXPECT_EQ(marks_after({echo(0, 2000)}), 2U) << "it looks elsewhere";
  EXPECT_EQ(marks_after({echo(2900, 0)}), 1U) << "only this place is free";
  EXPECT_EQ(seen_.marks()[0].y, 2000);
}

TEST_F(SeenObstaclesTest, AnOldScanMarksNothing) {
  Scan2dData scan;
  scan.points.push_back(echo(1000, 0));
  seen_.take(scan, {});
  seen_.begin();
  seen_.update(space_, &space_);
  EXPECT_TRUE(seen_.marks().empty());
}

TEST_F(SeenObstaclesTest, RemembersALimitedNumber) {
  Scan2dData scan;
  for (std::size_t i = 0; i < 1000; ++i) scan.points.push_back(echo(1000, 0));
  for (std::size_t i = 0; i < SeenObstacles::kMost; i += 1000) {
    seen_.take(scan, {});
    seen_.update(space_, nullptr);
  }
  EXPECT_EQ(seen_.marks().size(), SeenObstacles::kMost);
  seen_.update(space_, nullptr);
  EXPECT_EQ(seen_.marks().size(), SeenObstacles::kMost);
}

}  // namespace seen_obstacles_test
}  // namespace rack::path
