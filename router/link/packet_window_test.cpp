#include "router/link/packet_window.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

TEST(PacketWindow, ANumberIsNewOnce) {
  PacketWindow window;
  EXPECT_TRUE(window.is_new(0));
  window.add(0);
  EXPECT_FALSE(window.is_new(0));
  window.add(5);
  EXPECT_TRUE(window.is_new(3));
  EXPECT_FALSE(window.is_new(5));
}

TEST(PacketWindow, WhatIsTooOldCountsAsKnown) {
  PacketWindow window;
  window.add(PacketWindow::kWindow);
  EXPECT_FALSE(window.is_new(0));
  EXPECT_TRUE(window.is_new(1));
  window.add(10 * PacketWindow::kWindow);  // a leap forgets everything
  EXPECT_FALSE(window.is_new(PacketWindow::kWindow));
  EXPECT_TRUE(window.is_new(10 * PacketWindow::kWindow - 1));
}

TEST(PacketWindow, ThirtyTwoBitsAreEnough) {
  PacketWindow window;
  EXPECT_EQ(window.expand(7), 7U);
  const std::uint64_t turn = std::uint64_t{1} << 32;
  window.add(turn - 1);
  EXPECT_EQ(window.expand(0), turn);
  EXPECT_EQ(window.expand(0xFFFFFFFF), turn - 1);
  window.add(turn + 5);
  EXPECT_EQ(window.expand(0xFFFFFFFE), turn - 2);
}

TEST(PacketWindow, AcknowledgesTheNewestRanges) {
  PacketWindow window;
  Ack ack;
  window.fill(ack);
  EXPECT_EQ(ack.count, 0);
  for (std::uint64_t n = 0; n < 200; ++n)
    if (n % 10 != 3) window.add(n);
  window.fill(ack);
  ASSERT_EQ(ack.count, 21);
  EXPECT_EQ(ack.ranges[0].first, 194U);
  EXPECT_EQ(ack.ranges[0].last, 199U);
  EXPECT_EQ(ack.ranges[20].first, 0U);
  EXPECT_EQ(ack.ranges[20].last, 2U);
}

TEST(PacketWindow, ManyGapsAreCutOff) {
  PacketWindow window;
  for (std::uint64_t n = 0; n < 1000; n += 2) window.add(n);
  Ack ack;
  window.fill(ack);
  EXPECT_EQ(ack.count, Ack::kRangesMax);
  EXPECT_EQ(ack.ranges[0].first, 998U);
}

}  // namespace
}  // namespace tims::link
