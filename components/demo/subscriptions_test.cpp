#include "components/demo/subscriptions.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

namespace tims::demo {
namespace {

using namespace std::chrono_literals;

std::array<std::byte, 8> body_of(std::uint32_t period_ms, Address mailbox) {
  std::array<std::byte, 8> body;
  const std::uint32_t raw = mailbox.raw();
  std::memcpy(body.data(), &period_ms, 4);
  std::memcpy(body.data() + 4, &raw, 4);
  return body;
}

int deliveries(Subscriptions& subscriptions, Time now, bool keep = true) {
  int count = 0;
  subscriptions.deliver(now, [&](const auto&) { return ++count, keep; });
  return count;
}

TEST(Subscriptions, GrantsMultiplesOfTheSamplePeriod) {
  Subscriptions subscriptions;
  const Header request;
  EXPECT_EQ(subscriptions.add(request, body_of(0, Address(1)), 13), 13U);
  EXPECT_EQ(subscriptions.add(request, body_of(12, Address(2)), 13), 13U);
  EXPECT_EQ(subscriptions.add(request, body_of(100, Address(3)), 13), 91U);
  EXPECT_EQ(subscriptions.size(), 3U);
}

TEST(Subscriptions, DeliversWhatIsDue) {
  Subscriptions subscriptions;
  subscriptions.add({}, body_of(100, Address(1)), 10);
  Time now{1s};
  EXPECT_EQ(deliveries(subscriptions, now), 1);
  EXPECT_EQ(deliveries(subscriptions, now + 50ms), 0);
  EXPECT_EQ(deliveries(subscriptions, now + 100ms), 1);
}

TEST(Subscriptions, TheSameMailboxAgainChangesItsPeriod) {
  Subscriptions subscriptions;
  subscriptions.add({}, body_of(0, Address(1)), 10);
  subscriptions.add({}, body_of(50, Address(1)), 10);
  EXPECT_EQ(subscriptions.size(), 1U);
}

TEST(Subscriptions, EndByRequestOrWhenSendingFails) {
  Subscriptions subscriptions;
  subscriptions.add({}, body_of(0, Address(1)), 10);
  subscriptions.add({}, body_of(0, Address(2)), 10);
  const std::uint32_t first = 1;
  subscriptions.remove({}, std::as_bytes(std::span(&first, 1)));
  EXPECT_EQ(subscriptions.size(), 1U);
  deliveries(subscriptions, Time{1s}, false);
  EXPECT_EQ(subscriptions.size(), 0U);
}

TEST(Subscriptions, ReadsBothByteOrdersAndRefusesShortBodies) {
  Subscriptions subscriptions;
  const auto big = body_of(__builtin_bswap32(100), Address(__builtin_bswap32(5)));
  EXPECT_EQ(subscriptions.add({.flags = 0}, big, 10), 100U);
  EXPECT_EQ(subscriptions.add({}, std::span(big).first(7), 10), std::nullopt);
  subscriptions.deliver(Time{1s}, [](const auto& s) {
    EXPECT_EQ(s.data_mailbox, Address(5));
    return true;
  });
}

}  // namespace
}  // namespace tims::demo
