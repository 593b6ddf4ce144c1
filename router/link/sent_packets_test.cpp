#include "router/link/sent_packets.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

using namespace std::chrono_literals;

struct SentPacketsTest : testing::Test, PacketFate {
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

}  // namespace
}  // namespace tims::link
