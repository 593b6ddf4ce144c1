#include "components/demo/scan.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::demo {
namespace {

TEST(Scan, ReadsWhatItWrote) {
  std::vector<std::byte> body(kScanBytes);
  write_scan(7, 1234, std::span<std::byte, kScanBytes>(body));
  ScanSummary summary;
  ASSERT_TRUE(read_scan(body, summary));
  EXPECT_EQ(summary.time_ms, 1234U);
  EXPECT_EQ(summary.points, 361U);
  EXPECT_GE(summary.nearest_mm, 2500);
  EXPECT_LE(summary.nearest_mm, 3500);
}

TEST(Scan, RefusesCountsThatDoNotFit) {
  std::vector<std::byte> body(kScanBytes);
  write_scan(0, 0, std::span<std::byte, kScanBytes>(body));
  ScanSummary summary;
  for (const std::size_t size : {std::size_t{0}, kScanHead - 1, kScanBytes - 1})
    EXPECT_FALSE(read_scan(std::span(body).first(size), summary)) << size;
}

}  // namespace
}  // namespace tims::demo
