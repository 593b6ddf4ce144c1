#include "router/link/handover.h"

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace tims::link {
namespace handover_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr Time kNow{100s};
constexpr std::size_t kVersionAt = 8;

Handover sample() {
  Handover left{.at = kNow,
                .table_number = 7,
                .self = {.epoch = 1, .role = Role::kSystem, .system = 1, .id = 1, .name = "robot"},
                .exported = {Address(1), Address(2), Address(9)},
                .mailboxes = {Address(9), Address(1)}};
  left.self.message_max = 1 << 20;
  left.self.classes = left.self.classes.at(left.self.widths);
  left.links.assign(100, std::byte{42});
  return left;
}

std::string why_not(Time now, const std::vector<std::byte>& bytes) {
  const auto read = Handover::decode(now, bytes);
  return read ? "" : read.error().detail();
}

TEST(Handover, IsReadAsItWasWritten) {
  const Handover left = sample();
  const auto read = Handover::decode(kNow + 1ms, left.encode());
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(read->at, left.at);
  EXPECT_EQ(read->table_number, left.table_number);
  EXPECT_EQ(read->self, left.self);
  EXPECT_EQ(read->exported, left.exported);
  EXPECT_EQ(read->mailboxes, left.mailboxes);
  EXPECT_EQ(read->links, left.links);
}

TEST(Handover, OfAnotherLayoutIsNotRead) {
  for (const unsigned version : {Handover::kVersion - 1, Handover::kVersion + 1, 255U}) {
    auto other = sample().encode();
    other[kVersionAt] = static_cast<std::byte>(version);
    EXPECT_THAT(why_not(kNow, other), HasSubstr("layout " + std::to_string(version)));
  }
}

TEST(Handover, DamageIsFound) {
  const auto whole = sample().encode();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    auto damaged = whole;
    damaged[at] ^= std::byte{0x10};
    EXPECT_NE(why_not(kNow, damaged), "") << at;
    const std::vector cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at));
    EXPECT_NE(why_not(kNow, cut), "") << at;
  }
  auto longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_NE(why_not(kNow, longer), "");
}

TEST(Handover, IsReadForAWhile) {
  const auto bytes = sample().encode();
  EXPECT_EQ(why_not(kNow + Handover::kAgeMax, bytes), "");
  EXPECT_THAT(why_not(kNow + Handover::kAgeMax + 1ns, bytes), HasSubstr("too old"));
  EXPECT_NE(why_not(kNow - 1ns, bytes), "") << "of another boot";
}

TEST(Handover, AddressesAreInOrder) {
  Handover left = sample();
  std::swap(left.exported[0], left.exported[1]);
  EXPECT_NE(why_not(kNow, left.encode()), "");
}

// A time of the state is never after the present one.
TEST(StateReader, LimitsTimes) {
  StateWriter out;
  out.put(kNow - 1s, kNow + 1s);
  StateReader in(kNow, out.bytes());
  EXPECT_EQ(in.time(), kNow - 1s);
  EXPECT_EQ(in.time(), kNow);
  EXPECT_TRUE(in.ok() && in.empty());
}

TEST(StateReader, FailsBehindTheEnd) {
  StateWriter out;
  out.put(std::uint32_t{5});
  StateReader in(kNow, out.bytes());
  EXPECT_TRUE(in.bytes().empty());
  EXPECT_FALSE(in.ok());
}

}  // namespace handover_test
}  // namespace tims::link
