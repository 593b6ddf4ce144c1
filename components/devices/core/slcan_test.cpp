#include "components/devices/core/slcan.h"

#include <gtest/gtest.h>

namespace rack::device::slcan {
namespace slcan_test {

std::string written(const Frame& frame) {
  std::string text;
  append(text, frame.id, frame.view());
  return text;
}

TEST(SlcanTest, FramesOfTheAdaptersManualAreReadAndWritten) {
  for (const std::string line :
       {"t10021133", "T0000010021133", "t1230", "r1230", "R1FFFFFFF0", "t7FF81122334455667788"}) {
    const auto frame = parse(line);
    ASSERT_TRUE(frame) << line;
    EXPECT_EQ(written(*frame), line + "\r");
  }
  EXPECT_EQ(parse("T0000010021133")->id, 0x80000100U);
  EXPECT_EQ(parse("r1230")->id, 0x40000123U);
  EXPECT_EQ(parse("t10021133")->bytes[1], std::byte{0x33});
}

TEST(SlcanTest, TheTimeBehindAFrameIsPassedOver) {
  EXPECT_EQ(parse("t10021133ABCD")->size, 2U);
  EXPECT_FALSE(parse("t10021133ABC"));
}

TEST(SlcanTest, WhatIsNoFrameIsNone) {
  for (const char* line : {"", "z", "t", "t12", "t123", "t1239", "t8000", "T200000000", "t12G0",
                           "t123211", "t12321X33", "V1013", "tFFFFFFFFF"})
    EXPECT_FALSE(parse(line)) << line;
}

TEST(SlcanTest, ABitRateIsANumberOfTheAdapter) {
  EXPECT_EQ(opening(500000), "C\rS6\rO\r");
  EXPECT_EQ(opening(1000000), "C\rS8\rO\r");
  EXPECT_FALSE(opening(333333));
}

}  // namespace slcan_test
}  // namespace rack::device::slcan
