#include "components/runtime/logic/listeners.h"

#include <array>

#include <gtest/gtest.h>

namespace rack {
namespace listeners_test {

using Added = Listeners::Added;

constexpr tims::Address kSource(0x00100000);
constexpr tims::Address kOther(0x00110000);
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
  EXPECT_EQ(listeners.add(request(kFirst), kSource, kFirst, 1), Added::kNew);
  EXPECT_EQ(listeners.add(request(kSecond), kSource, kSecond, 3), Added::kNew);
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
  const auto third = listeners.take_due(due);
  ASSERT_EQ(third.size(), 2U);
  EXPECT_EQ(third[1].mailbox, kSecond);
  EXPECT_EQ(third[1].priority, 9);
  EXPECT_EQ(third[1].seq_nr, 1);
}

TEST_F(ListenersTest, ASecondRequestChangesOnlyTheReduction) {
  (void)listeners.add(request(kFirst, 1, 9), kSource, kFirst, 1);
  EXPECT_EQ(listeners.add(request(kFirst, 2, 3), kSource, kFirst, 2), Added::kChanged);
  EXPECT_EQ(listeners.add(request(kFirst, 2, 3), kSource, kFirst, 2), Added::kAgain);
  EXPECT_TRUE(listeners.take_due(due).empty());
  const auto second = listeners.take_due(due);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].priority, 9);
  EXPECT_EQ(second[0].seq_nr, 1);
}

TEST_F(ListenersTest, NextDataOnce) {
  EXPECT_EQ(listeners.add_once(request(kFirst, 42), kSource), Added::kNew);
  const auto first = listeners.take_due(due);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].seq_nr, 42);
  EXPECT_TRUE(listeners.take_due(due).empty());
}

TEST_F(ListenersTest, AContinuousListenerThatAsksForTheNextBecomesOneOfOnce) {
  (void)listeners.add(request(kFirst, 1), kSource, kFirst, 5);
  EXPECT_EQ(listeners.add_once(request(kFirst, 2), kSource), Added::kChanged);
  const auto next = listeners.take_due(due);
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].seq_nr, 2);
  EXPECT_TRUE(listeners.all().empty());
}

TEST_F(ListenersTest, NoMoreThanMax) {
  (void)listeners.add(request(kFirst), kSource, kFirst, 1);
  (void)listeners.add(request(kSecond), kSource, kSecond, 1);
  EXPECT_EQ(listeners.add(request(tims::Address(3)), kSource, tims::Address(3), 1), Added::kFull);
  EXPECT_EQ(listeners.add_once(request(tims::Address(3)), kSource), Added::kFull);
  EXPECT_EQ(listeners.add_once(request(kSecond), kSource), Added::kAgain);
  EXPECT_TRUE(listeners.remove(kFirst));
  EXPECT_FALSE(listeners.remove(kFirst));
  EXPECT_EQ(listeners.add(request(tims::Address(3)), kSource, tims::Address(3), 1), Added::kNew);
}

TEST_F(ListenersTest, RareOnesAreThoseWithoutTheNewestDataSet) {
  (void)listeners.add(request(kFirst), kSource, kFirst, 1);
  (void)listeners.add(request(kSecond), kSource, kSecond, 2);
  EXPECT_EQ(listeners.take_rare(due).size(), 2U) << "nothing was sent yet";
  EXPECT_TRUE(listeners.take_rare(due).empty()) << "once a data set";
  (void)listeners.take_due(due);
  const auto rare = listeners.take_rare(due);
  ASSERT_EQ(rare.size(), 1U);
  EXPECT_EQ(rare[0].mailbox, kSecond);
  (void)listeners.take_due(due);
  EXPECT_TRUE(listeners.take_rare(due).empty()) << "both got the second";
}

TEST_F(ListenersTest, ThoseOfOnceGetTheNextDataSetOnly) {
  (void)listeners.add_once(request(kFirst), kSource);
  EXPECT_TRUE(listeners.take_rare(due).empty());
}

TEST(ListenersShare, OneWithMorePlacesGivesToOneWithFewer) {
  Listeners listeners(4);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const tims::Address mailbox(0x100 + i);
    ASSERT_EQ(listeners.add(request(mailbox), kSource, mailbox, 1), Added::kNew);
  }
  EXPECT_FALSE(listeners.make_place(kSource)) << "its own";
  for (std::uint32_t i = 0; i < 2; ++i) {
    const auto given = listeners.make_place(kOther);
    ASSERT_TRUE(given);
    EXPECT_EQ(given->mailbox, tims::Address(0x103 - i)) << "the newest";
    const tims::Address mailbox(0x200 + i);
    EXPECT_EQ(listeners.add(request(mailbox), kOther, mailbox, 1), Added::kNew);
  }
  EXPECT_FALSE(listeners.make_place(kOther)) << "both have two";
  EXPECT_TRUE(listeners.make_place(kFirst)) << "has none";
}

TEST_F(ListenersTest, AnOldReportDoesNotRemoveANewSubscription) {
  constexpr tims::Time kAsked{std::chrono::seconds(100)};
  constexpr auto kOld = Listeners::kReportMayBeOld;
  (void)listeners.add(request(kFirst), kSource, kFirst, 1, kAsked - kOld);
  (void)listeners.add(request(kFirst), kSource, kFirst, 1, kAsked);
  EXPECT_FALSE(listeners.remove_gone(kFirst, kAsked + kOld - std::chrono::nanoseconds(1)));
  EXPECT_EQ(listeners.all().size(), 1U);
  EXPECT_TRUE(listeners.remove_gone(kFirst, kAsked + kOld));
  EXPECT_FALSE(listeners.remove_gone(kFirst, kAsked + kOld));
}

TEST_F(ListenersTest, CountFromZeroAfterClearing) {
  (void)listeners.take_due(due);
  listeners.clear();
  (void)listeners.add(request(kFirst), kSource, kFirst, 2);
  EXPECT_TRUE(listeners.take_due(due).empty());
  EXPECT_EQ(listeners.take_due(due).size(), 1U);
}

}  // namespace listeners_test
}  // namespace rack
