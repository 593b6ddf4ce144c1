#include "components/scan3d/range_image.h"

#include <gtest/gtest.h>

namespace rack::scan3d {
namespace range_image_test {

Scan3dData scan(i32 mode) {
  Scan3dData scan{.recordingTime = 9,
                  .maxRange = 8000,
                  .scanNum = 2,
                  .scanPointNum = 3,
                  .scanMode = mode | scan_mode::kPositiveTurn};
  scan.points = {{.x = 3, .y = 4},          {.x = 1}, {.x = 2}, {.type = scan_point::kInvalid},
                 {.x = 100'000, .z = -200}, {.z = 7}};
  return scan;
}

TEST(RangeImage, HasARowForEachFlatScan) {
  const auto image = range_image(scan(scan_mode::kTop));
  EXPECT_EQ(image.recordingTime, TimeStamp(9));
  EXPECT_EQ(image.maxRange, 8000);
  EXPECT_EQ(image.scanMode, scan_mode::kTop | scan_mode::kPositiveTurn);
  ASSERT_EQ(image.points.size(), 6U);
  EXPECT_EQ(image.points[0].range, 5);
  EXPECT_EQ(image.points[3].range, 0);
  EXPECT_EQ(image.points[3].type, scan_point::kInvalid);
  EXPECT_EQ(image.points[4].range, 32767) << "the largest";
  EXPECT_EQ(image.points[5].range, 7);
}

TEST(RangeImage, MirrorsWhatPitches) {
  const auto image = range_image(scan(scan_mode::kPitch));
  EXPECT_EQ(image.points[0].range, 2);
  EXPECT_EQ(image.points[2].range, 5);
  EXPECT_EQ(image.points[3].range, 7);
}

TEST(RangeImage, TakesAnyNumbers) {
  Scan3dData odd = scan(scan_mode::kYaw);
  for (const auto& [rows, columns] : {std::pair{5, 3},
                                      {1, 3},
                                      {-1, 3},
                                      {3, -1},
                                      {0, 0},
                                      {2147483647, 2147483647},
                                      {1, 2147483647},
                                      {40000, 1}}) {
    odd.scanNum = rows;
    odd.scanPointNum = columns;
    const auto image = range_image(odd);
    EXPECT_EQ(image.points.size(), static_cast<std::size_t>(image.scanNum) *
                                       static_cast<std::size_t>(image.scanPointNum));
    EXPECT_LE(image.points.size(), kScan3dPointsMax);
    EXPECT_TRUE(codec::check(image));
  }
}

TEST(RangeImage, PointsAreLines) {
  Scan3dData few;
  few.points = {{.x = 1, .y = -2, .z = 3, .type = 16, .segment = -4, .intensity = 5}, {}};
  EXPECT_EQ(point_lines(few), "1 -2 3 16 -4 5\n0 0 0 0 0 0\n");
}

}  // namespace range_image_test
}  // namespace rack::scan3d
