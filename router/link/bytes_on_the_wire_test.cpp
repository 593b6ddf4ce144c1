// Datagrams, frames and control messages: what is written reads back, what is cut is refused.
#include <vector>

#include <gtest/gtest.h>

#include "router/link/bytes.h"
#include "router/link/control.h"
#include "router/link/datagram.h"
#include "router/link/frame.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

Hello hello() {
  return {.kind = LinkKind::kPeer,
          .token = 11,
          .resume = 12,
          .keep_alive = 300ms,
          .who = {.epoch = 5,
                  .role = Role::kTop,
                  .system = 3,
                  .id = 4,
                  .name = std::string_view("base"),
                  .message_max = 1000}};
}

TEST(Datagram, AHelloReadsBackAndMayNotBeCut) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(hello(), bytes);
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  const auto& back = std::get<Hello>(*datagram);
  EXPECT_EQ(back.token, 11U);
  EXPECT_EQ(back.resume, 12U);
  EXPECT_EQ(back.keep_alive, 300ms);
  EXPECT_EQ(back.who.name.view(), "base");
  EXPECT_EQ(back.who.id, 4);
  for (std::size_t n = 0; n < size; ++n)
    EXPECT_FALSE(decode(std::span(bytes).first(n)).has_value()) << n;
}

TEST(Datagram, ARouterHasAnEpoch) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  Hello nobody = hello();
  nobody.who.epoch = 0;
  EXPECT_FALSE(decode(std::span(bytes).first(encode(nobody, bytes))).has_value());
}

TEST(Datagram, KeepAlivesAreNeverTooShort) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  Hello hasty = hello();
  hasty.keep_alive = 0ms;
  const auto datagram = decode(std::span(bytes).first(encode(hasty, bytes)));
  EXPECT_EQ(std::get<Hello>(*datagram).keep_alive, 10ms);
}

TEST(Datagram, AnUnknownVersionKeepsItsToken) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(hello(), bytes);
  bytes[1] = bytes[2] = std::byte{9};
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(std::get<Hello>(*datagram).version_min, 9);
  EXPECT_EQ(std::get<Hello>(*datagram).token, 11U);
}

TEST(Frame, AllKindsReadBack) {
  std::array<std::byte, 400> bytes{};
  ByteWriter out(bytes);
  put(out, KeepAlive{.deaf = true,
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
  put_close(out, 8);
  FrameReader reader(out.written());
  const auto keep_alive = std::get<KeepAlive>(*reader.next());
  EXPECT_TRUE(keep_alive.deaf);
  EXPECT_EQ(keep_alive.wall_ns, -5);
  EXPECT_EQ(std::get<Ack>(*reader.next()).ranges[1].last, 2U);
  EXPECT_EQ(std::get<SkipFrame>(*reader.next()).to, 77U);
  EXPECT_EQ(std::get<ChallengeFrame>(*reader.next()).nonce, 99U);
  EXPECT_EQ(std::get<StreamFrame>(*reader.next()).offset, 1000U);
  EXPECT_EQ(std::get<SampleFrame>(*reader.next()).bytes.size(), 4U);
  EXPECT_EQ(std::get<CloseFrame>(*reader.next()).reason, 8);
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

}  // namespace
}  // namespace tims::link
