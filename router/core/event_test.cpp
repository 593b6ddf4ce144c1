#include "router/core/event.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace {

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

}  // namespace
}  // namespace tims::core
