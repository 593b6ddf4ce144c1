#include "router/core/statistics.h"

#include <gtest/gtest.h>

#include "router/core/types.h"

namespace tims::core {
namespace statistics_test {

enum class Colour { kRed, kGreen };

TEST(Labels, AListIsCompleteWhenItHasEveryValueInOrder) {
  using L = Label<Colour>;
  const L red{Colour::kRed, "red", ""};
  const L green{Colour::kGreen, "green", ""};
  EXPECT_TRUE(complete(std::array{red, green}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{green, red}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{red}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{red, L{Colour::kGreen, "", ""}}, Colour::kGreen));
}

TEST(Labels, NamesSayWhatTheyMean) {
  EXPECT_EQ(name(Outcome::kQueueReplaced), "queue_replaced");
  EXPECT_EQ(name(PortKind::kWebSocket), "websocket");
  EXPECT_EQ(name(EventKind::kDeleteRefused), "delete_refused");
  EXPECT_EQ(name(CloseReason::kTooLong), "too_long");
  EXPECT_TRUE(sentence(Outcome::kNoRoute).starts_with("the destination is not registered"));
}

TEST(Labels, OnlySomeOutcomesMeanThatAMessageWasTaken) {
  EXPECT_TRUE(taken(Outcome::kDelivered));
  EXPECT_TRUE(taken(Outcome::kMailboxReplaced));
  EXPECT_FALSE(taken(Outcome::kQueueReplaced));
}

TEST(EventLog, IsEmptyAtFirst) {
  const EventLog log;
  EXPECT_EQ(log.last(), 0U);
  EXPECT_EQ(log.oldest(), 1U);
}

TEST(EventLog, NumbersEventsFrom1) {
  EventLog log;
  EXPECT_EQ(log.add({.kind = EventKind::kRegistered, .address = Address(7)}).sequence, 1U);
  EXPECT_EQ(log.add({.kind = EventKind::kWithdrawn}).sequence, 2U);
  EXPECT_EQ(log.at(1).address, Address(7));
  EXPECT_EQ(log.at(2).kind, EventKind::kWithdrawn);
}

TEST(EventLog, KeepsTheNewest) {
  EventLog log;
  for (std::uint32_t i = 1; i <= EventLog::kCapacity + 10; ++i) log.add({.address = Address(i)});
  EXPECT_EQ(log.last(), EventLog::kCapacity + 10);
  EXPECT_EQ(log.oldest(), 11U);
  for (std::uint64_t i = log.oldest(); i <= log.last(); ++i) {
    ASSERT_EQ(log.at(i).sequence, i);
    ASSERT_EQ(log.at(i).address.raw(), i);
  }
}

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

}  // namespace statistics_test
}  // namespace tims::core
