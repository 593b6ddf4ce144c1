#include "router/core/counters.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace {

using namespace std::chrono_literals;

TEST(Counters, AddByPortClassAndOutcome) {
  MessageCounters counters;
  counters.add(PortKind::kTcp, 0, Outcome::kDelivered, 100);
  counters.add(PortKind::kTcp, 1, Outcome::kDelivered, 200);
  counters.add(PortKind::kLocal, std::size_t{1}, Outcome::kDelivered, Count{3, 30});
  EXPECT_EQ(counters.of(PortKind::kTcp, 0, Outcome::kDelivered), (Count{1, 100}));
  EXPECT_EQ(counters.of(PortKind::kTcp, 1, Outcome::kDelivered), (Count{1, 200}));
  EXPECT_EQ(counters.of(PortKind::kTcp, 1, Outcome::kNoRoute), Count{});
  EXPECT_EQ(counters.total(Outcome::kDelivered), (Count{5, 330}));
}

TEST(DropHistory, ForgetsAfterAMinute) {
  DropHistory drops;
  const Time start(1000s);
  EXPECT_EQ(drops.last_minute(start), 0U);
  drops.add(start);
  drops.add(start + 500ms, 2);
  drops.add(start + 30s, 10);
  EXPECT_EQ(drops.last_minute(start + 30s), 13U);
  EXPECT_EQ(drops.last_minute(start + 59s), 13U);
  EXPECT_EQ(drops.last_minute(start + 60s), 10U);
  EXPECT_EQ(drops.last_minute(start + 1h), 0U);
  drops.add(start + 90s);
  EXPECT_EQ(drops.last_minute(start + 90s), 1U);
}

TEST(Text, IsCutWhenItIsTooLong) {
  EXPECT_EQ(Text<5>("abc").view(), "abc");
  EXPECT_EQ(Text<5>("abcdefg").view(), "abcde");
  EXPECT_TRUE(Text<5>().empty());
}

}  // namespace
}  // namespace tims::core
