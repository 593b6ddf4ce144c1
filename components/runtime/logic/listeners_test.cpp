#include "components/runtime/logic/listeners.h"

#include <array>

#include <gtest/gtest.h>

namespace rack {
namespace listeners_test {

using Added = Listeners::Added;

constexpr tims::Address kFirst(0x00180002);
constexpr tims::Address kSecond(0x00190002);

tims::Header request(tims::Address from, std::uint8_t seq_nr = 1, std::uint8_t priority = 9) {
  return {.priority = priority, .seq_nr = seq_nr, .src = from};
}

struct Fixture : testing::Test {
  Listeners listeners{2};
  std::array<Listener, 2> due{};
};
using ListenersTest = Fixture;

// Specification, section 6.3, with a period of 100 ms.
TEST(Reduction, OfAPeriod) {
  EXPECT_EQ(reduction(0, 100), 1U);
  EXPECT_EQ(reduction(50, 100), 1U);
  EXPECT_EQ(reduction(100, 100), 1U);
  EXPECT_EQ(reduction(199, 100), 1U);
  EXPECT_EQ(reduction(200, 100), 2U);
  EXPECT_EQ(reduction(250, 100), 2U);
  EXPECT_EQ(reduction(1000, 100), 10U);
}

TEST_F(ListenersTest, GetEachSoManyThDataSet) {
  EXPECT_EQ(listeners.add(request(kFirst), kFirst, 1), Added::kNew);
  EXPECT_EQ(listeners.add(request(kSecond), kSecond, 3), Added::kNew);
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
  const auto third = listeners.take_due(due);
  ASSERT_EQ(third.size(), 2U);
  EXPECT_EQ(third[1].mailbox, kSecond);
  EXPECT_EQ(third[1].priority, 9);
  EXPECT_EQ(third[1].seq_nr, 1);
}

TEST_F(ListenersTest, ASecondRequestChangesOnlyTheReduction) {
  (void)listeners.add(request(kFirst, 1, 9), kFirst, 1);
  EXPECT_EQ(listeners.add(request(kFirst, 2, 3), kFirst, 2), Added::kAgain);
  EXPECT_TRUE(listeners.take_due(due).empty());
  const auto second = listeners.take_due(due);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].priority, 9);
  EXPECT_EQ(second[0].seq_nr, 1);
}

TEST_F(ListenersTest, NextDataOnce) {
  EXPECT_EQ(listeners.add_once(request(kFirst, 42)), Added::kNew);
  const auto first = listeners.take_due(due);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].seq_nr, 42);
  EXPECT_TRUE(listeners.take_due(due).empty());
}

TEST_F(ListenersTest, AContinuousListenerThatAsksForTheNextBecomesOneOfOnce) {
  (void)listeners.add(request(kFirst, 1), kFirst, 5);
  EXPECT_EQ(listeners.add_once(request(kFirst, 2)), Added::kAgain);
  const auto next = listeners.take_due(due);
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].seq_nr, 2);
  EXPECT_TRUE(listeners.all().empty());
}

TEST_F(ListenersTest, NoMoreThanMax) {
  (void)listeners.add(request(kFirst), kFirst, 1);
  (void)listeners.add(request(kSecond), kSecond, 1);
  EXPECT_EQ(listeners.add(request(tims::Address(3)), tims::Address(3), 1), Added::kFull);
  EXPECT_EQ(listeners.add_once(request(tims::Address(3))), Added::kFull);
  EXPECT_EQ(listeners.add_once(request(kSecond)), Added::kAgain);
  EXPECT_TRUE(listeners.remove(kFirst));
  EXPECT_FALSE(listeners.remove(kFirst));
  EXPECT_EQ(listeners.add(request(tims::Address(3)), tims::Address(3), 1), Added::kNew);
}

TEST_F(ListenersTest, AnOldReportDoesNotRemoveANewSubscription) {
  constexpr tims::Time kAsked{std::chrono::seconds(100)};
  constexpr auto kOld = Listeners::kReportMayBeOld;
  (void)listeners.add(request(kFirst), kFirst, 1, kAsked - kOld);
  (void)listeners.add(request(kFirst), kFirst, 1, kAsked);
  EXPECT_FALSE(listeners.remove_gone(kFirst, kAsked + kOld - std::chrono::nanoseconds(1)));
  EXPECT_EQ(listeners.all().size(), 1U);
  EXPECT_TRUE(listeners.remove_gone(kFirst, kAsked + kOld));
  EXPECT_FALSE(listeners.remove_gone(kFirst, kAsked + kOld));
}

TEST_F(ListenersTest, CountFromZeroAfterClearing) {
  (void)listeners.take_due(due);
  listeners.clear();
  (void)listeners.add(request(kFirst), kFirst, 2);
  EXPECT_TRUE(listeners.take_due(due).empty());
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
}

}  // namespace listeners_test
}  // namespace rack
