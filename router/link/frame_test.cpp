#include "router/link/frame.h"

#include <vector>

#include <gtest/gtest.h>

#include "router/link/datagram.h"

namespace tims::link {
namespace frame_test {

TEST(Frame, AllKindsReadBack) {
  std::array<std::byte, 400> bytes{};
  ByteWriter out(bytes);
  put(out, KeepAlive{.nothing_received = true,
                     .questions = 127,
                     .sent_ns = 1,
                     .echo_ns = 2,
                     .held_us = 3,
                     .loss_permille = 4,
                     .wall_ns = -5,
                     .table_number = 6,
                     .table_hash = 7});
  EXPECT_EQ(out.size(), kKeepAliveSize);
  Ack ack{.delay = 9, .count = 2};
  ack.ranges[0] = {5, 6};
  ack.ranges[1] = {1, 2};
  put(out, ack);
  put(out, SkipFrame{3, 77});
  put_challenge(out, FrameType::kChallenge, 99);
  put_header(out, 2, 1000, 4);
  out.reserve(4);
  put_header(out, SampleFrame{.hops = 1, .number = 2, .total = 30, .offset = 26}, 4);
  out.reserve(4);
  put(out, CloseFrame{8});
  put(out, PauseFrame{5000});
  put(out, NotReadyFrame{0x101});
  FrameReader reader(out.written());
  const auto keep_alive = std::get<KeepAlive>(*reader.next());
  EXPECT_TRUE(keep_alive.nothing_received);
  EXPECT_EQ(keep_alive.questions, 127);
  EXPECT_EQ(keep_alive.wall_ns, -5);
  EXPECT_EQ(std::get<Ack>(*reader.next()).ranges[1].last, 2U);
  EXPECT_EQ(std::get<SkipFrame>(*reader.next()).to, 77U);
  EXPECT_EQ(std::get<ChallengeFrame>(*reader.next()).nonce, 99U);
  EXPECT_EQ(std::get<StreamFrame>(*reader.next()).offset, 1000U);
  EXPECT_EQ(std::get<SampleFrame>(*reader.next()).bytes.size(), 4U);
  EXPECT_EQ(std::get<CloseFrame>(*reader.next()).reason, 8);
  EXPECT_EQ(std::get<PauseFrame>(*reader.next()).longest_ms, 5000);
  EXPECT_EQ(std::get<NotReadyFrame>(*reader.next()).lanes, 0x101);
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_TRUE(reader.ok());
}

TEST(Frame, WhatCannotBeIsRefused) {
  const auto refused = [](auto write) {
    std::array<std::byte, 64> bytes{};
    ByteWriter out(bytes);
    write(out);
    FrameReader reader(out.written());
    while (reader.next()) {
    }
    return !reader.ok();
  };
  EXPECT_TRUE(refused([](ByteWriter& out) { out.put(std::uint8_t{200}); }));
  EXPECT_TRUE(refused([](ByteWriter& out) { put(out, SkipFrame{kControlLane, 1}); }));
  EXPECT_TRUE(refused([](ByteWriter& out) { put_header(out, 0, 0, 0); }));
  EXPECT_TRUE(refused([](ByteWriter& out) { put_header(out, 0, 0, 5), out.reserve(4); }));
  EXPECT_FALSE(refused([](ByteWriter& out) { put_header(out, 0, 0, 5), out.reserve(5); }));
  EXPECT_TRUE(refused([](ByteWriter& out) { put_header(out, kLanes, 0, 1), out.reserve(1); }));
  EXPECT_TRUE(refused([](ByteWriter& out) {
    put_header(out, SampleFrame{.number = 1, .total = 30, .offset = 27}, 4), out.reserve(4);
  }));
}

TEST(Control, AnnouncementsReadBackInGroups) {
  ControlMessage message(control::kAdd);
  const core::Origin a{Address(1), 2, 3};
  const core::Origin b{Address(4), 5, 6};
  message.put(Address(100), a);
  message.put(Address(101), a);
  message.put(Address(102), b);
  const auto body = message.finish().subspan(kHeaderSize);
  std::vector<std::pair<std::uint32_t, std::uint8_t>> read;
  const auto visit = [&](Address address, const core::Origin& origin) {
    read.emplace_back(address.raw(), origin.hops);
  };
  EXPECT_TRUE(read_announcements(body, visit));
  EXPECT_EQ(read,
            (std::vector<std::pair<std::uint32_t, std::uint8_t>>{{100, 3}, {101, 3}, {102, 6}}));
  EXPECT_FALSE(read_announcements(body.first(body.size() - 1), visit));
}

}  // namespace frame_test
}  // namespace tims::link
