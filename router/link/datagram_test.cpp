#include "router/link/datagram.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

using namespace std::chrono_literals;

Hello hello() {
  return {.kind = LinkKind::kPeer,
          .token = 11,
          .resume = 12,
          .cookie = 13,
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
  EXPECT_EQ(back.cookie, 13U);
  EXPECT_EQ(back.keep_alive, 300ms);
  EXPECT_EQ(back.who.name.view(), "base");
  EXPECT_EQ(back.who.id, 4);
  for (std::size_t n = 0; n < size; ++n)
    EXPECT_FALSE(decode(std::span(bytes).first(n)).has_value()) << n;
}

TEST(Datagram, ARetryReadsBackAndMayNotBeCut) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(Retry{.echo = 11, .cookie = 12}, bytes);
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(std::get<Retry>(*datagram).echo, 11U);
  EXPECT_EQ(std::get<Retry>(*datagram).cookie, 12U);
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

}  // namespace
}  // namespace tims::link
