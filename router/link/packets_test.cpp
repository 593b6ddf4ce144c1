#include "router/link/packets.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace packets_test {

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

// Its contents come again, under another number.
TEST(PacketWindow, WhatWasSeenAndNotKeptIsNotAcknowledgedAndNotNew) {
  PacketWindow window;
  window.add(0);
  window.add(1, false);
  window.add(2);
  EXPECT_FALSE(window.is_new(1));
  Ack ack;
  window.fill(ack);
  ASSERT_EQ(ack.count, 2);
  EXPECT_EQ(ack.ranges[0].first, 2U);
  EXPECT_EQ(ack.ranges[1].last, 0U);
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

using namespace std::chrono_literals;

struct SentPacketsTest : testing::Test, PacketObserver {
  void on_packet_acked(const SentPacket& packet) override { acked.push_back(packet.skip_to); }
  void on_packet_lost(const SentPacket& packet) override { lost.push_back(packet.skip_to); }

  void send(Time at, bool eliciting = true) {
    SentPacket& packet = packets.add();
    packet.at = at;
    packet.size = 1000;
    packet.elicits_ack = eliciting;
    packet.skip_to = packets.next() - 1;  // its number, to look at
    packets.sent(packet);
  }
  SentPackets::AckResult ack(Time now, std::uint32_t first, std::uint32_t last) {
    Ack frame{.count = 1};
    frame.ranges[0] = {first, last};
    return packets.on_ack(now, frame, rtt, *this);
  }
  SentPackets packets;
  RttEstimator rtt;
  std::vector<std::uint64_t> acked;
  std::vector<std::uint64_t> lost;
  Time t{1s};
};

TEST_F(SentPacketsTest, ThreeLaterOnesMakeOneLost) {
  for (int i = 0; i < 5; ++i) send(t);
  ack(t + 1ms, 1, 3);
  EXPECT_EQ(lost, (std::vector<std::uint64_t>{0}));
  EXPECT_EQ(packets.bytes_in_flight(), 1000U);
}

TEST_F(SentPacketsTest, TwoLaterOnesOnlyAfterAWhile) {
  for (int i = 0; i < 3; ++i) send(t);
  ack(t + 1ms, 1, 2);
  EXPECT_TRUE(lost.empty());
  ASSERT_NE(packets.loss_time(), kNever);
  packets.detect_lost(packets.loss_time() - 1ns, rtt, *this);
  EXPECT_TRUE(lost.empty());
  packets.detect_lost(packets.loss_time(), rtt, *this);
  EXPECT_EQ(lost, (std::vector<std::uint64_t>{0}));
  EXPECT_EQ(packets.loss_time(), kNever);
  EXPECT_EQ(packets.last_eliciting(), kNever);
}

TEST_F(SentPacketsTest, WhatWasNeverSentCannotBeAcknowledged) {
  EXPECT_FALSE(ack(t, 0, 0).valid);
  send(t);
  EXPECT_FALSE(ack(t, 0, 1).valid);
  EXPECT_FALSE(ack(t, 1, 0).valid);
  EXPECT_FALSE(ack(t, 0xFFFFFFFF, 0xFFFFFFFF).valid);
  EXPECT_TRUE(ack(t, 0, 0).valid);
  EXPECT_EQ(acked.size(), 1U);
  EXPECT_FALSE(ack(t, 0, 0).any_new);
}

// Thirty-two ranges that are all the same cost as much as thirty-two datagrams.
TEST_F(SentPacketsTest, RangesDescendWithoutOverlap) {
  using Ranges = std::vector<PacketRange>;
  const auto is_valid = [&](const Ranges& ranges) {
    Ack frame{.count = static_cast<std::uint8_t>(ranges.size())};
    std::ranges::copy(ranges, frame.ranges.begin());
    return packets.on_ack(t, frame, rtt, *this).valid;
  };
  for (int i = 0; i < 10; ++i) send(t);
  for (const Ranges& wrong : std::vector<Ranges>{{{5, 9}, {5, 9}},
                                                 {{5, 9}, {3, 5}},
                                                 {{5, 9}, {6, 7}},
                                                 {{1, 2}, {5, 9}},
                                                 {{8, 9}, {5, 6}, {6, 6}},
                                                 {{0, 3}, {0, 0}}}) {
    EXPECT_FALSE(is_valid(wrong));
    EXPECT_TRUE(acked.empty());
  }
  EXPECT_TRUE(is_valid({{8, 9}, {5, 7}, {0, 2}}));
  EXPECT_EQ(acked.size(), 8U);
}

TEST_F(SentPacketsTest, WhatIsForgottenIsNotAcknowledged) {
  for (int i = 0; i < 3; ++i) send(t);
  packets.forget_all(*this);
  EXPECT_EQ(lost.size(), 3U);
  EXPECT_EQ(packets.bytes_in_flight(), 0U);
  EXPECT_TRUE(ack(t, 0, 2).valid);
  EXPECT_TRUE(acked.empty());
}

TEST_F(SentPacketsTest, HoldsManyAtOnce) {
  for (std::uint64_t i = 0; i < SentPackets::kInFlightMax; ++i) {
    ASSERT_FALSE(packets.full());
    send(t);
  }
  EXPECT_TRUE(packets.full());
  ack(t, 0, SentPackets::kInFlightMax - 1);
  EXPECT_FALSE(packets.full());
  EXPECT_EQ(acked.size(), SentPackets::kInFlightMax);
}

TEST_F(SentPacketsTest, AcknowledgementsAloneAreNotKept) {
  for (int i = 0; i < 100; ++i) send(t, false);
  EXPECT_EQ(packets.bytes_in_flight(), 0U);
  EXPECT_EQ(packets.oldest_in_flight(), nullptr);
}

}  // namespace packets_test
}  // namespace tims::link
