// One router's side of the exchange, its neighbours played by the test: hostile ones as well.
#include "router/link/list_exchange.h"

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::link {
namespace list_exchange_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kUp = 0;
constexpr std::uint32_t kDown = 1;

struct Sent {
  std::uint32_t slot = 0;
  std::int8_t type = 0;
  ListPlace place{};
  std::vector<std::byte> bytes{};
};
struct Check {
  std::uint64_t transfer = 0;
  std::uint64_t number = 0;
  std::uint32_t slot = 0;
  std::size_t size = 0;
};

class ListExchangeTest : public testing::Test, public ListExchange::Carrier {
 protected:
  // ListExchange::Carrier
  void send_list_message(Time, std::uint32_t slot, ControlMessage& message) override {
    const auto all = message.finish();
    Sent& one = sent.emplace_back();
    one.slot = slot;
    one.type = wire::decode_header(all.first<kHeaderSize>()).type;
    std::span<const std::byte> rest;
    EXPECT_TRUE(read_list_place(all.subspan(kHeaderSize), one.place, rest));
    one.bytes.assign(rest.begin(), rest.end());
  }
  std::size_t list_part_size(std::uint32_t) const override { return part_size; }
  void check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t slot,
                  std::vector<std::byte>&& bytes) override {
    checks.push_back({transfer, number, slot, bytes.size()});
  }

  bool give(std::uint32_t slot, std::int8_t type, const ListPlace& place,
            std::span<const std::byte> bytes = {}) {
    ControlMessage message(type);
    message.put(place);
    message.put(bytes);
    const auto made = message.finish();
    std::vector<std::byte> all(made.begin(), made.end());
    return exchange.on_control(now, slot, {.header = {.type = type}, .bytes = all});
  }
  bool offer(std::uint32_t slot, std::uint64_t number, std::uint32_t size = 100) {
    return give(slot, control::kList, {number, size});
  }
  bool part(std::uint32_t slot, const ListPlace& place, std::size_t size) {
    return give(slot, control::kListPart, place, std::vector<std::byte>(size));
  }
  void own(std::uint64_t number, std::size_t size = 5000) {
    exchange.set_own(now, {number, std::make_shared<const std::vector<std::byte>>(size)});
  }
  // The requests since the last call.
  std::vector<Sent> take(std::int8_t type) {
    std::vector<Sent> all;
    for (Sent& one : std::exchange(sent, {}))
      if (one.type == type) all.push_back(std::move(one));
    return all;
  }
  void pass(Duration time) {
    const Time end = now + time;
    while (exchange.next_timeout() <= end) {
      ASSERT_GE(exchange.next_timeout(), now);
      now = exchange.next_timeout();
      exchange.on_timeout(now);
      ASSERT_GT(exchange.next_timeout(), now);
    }
    now = end;
  }

  Time now{100s};
  std::size_t part_size = 2000;
  std::vector<Sent> sent;
  std::vector<Check> checks;
  ListExchange exchange{*this};
};

TEST_F(ListExchangeTest, EachSideIsToldTheOthersNumber) {
  exchange.begin(now, kDown, false);
  EXPECT_TRUE(sent.empty()) << "no list yet";
  own(7);
  const auto told = take(control::kList);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].place, (ListPlace{7, 5000}));
  exchange.begin(now, kUp, true);
  EXPECT_EQ(take(control::kList).size(), 1U);
  own(7);
  EXPECT_TRUE(sent.empty()) << "once";
}

TEST_F(ListExchangeTest, AListIsSentInPartsAsAskedFor) {
  exchange.begin(now, kDown, false);
  own(7);
  sent.clear();
  EXPECT_TRUE(give(kDown, control::kListGet, {7, 0}));
  EXPECT_TRUE(give(kDown, control::kListGet, {7, 4000}));
  EXPECT_TRUE(give(kDown, control::kListGet, {7, 5000})) << "nothing is there";
  EXPECT_TRUE(give(kDown, control::kListGet, {6, 0})) << "another list";
  const auto parts = take(control::kListPart);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].bytes.size(), 2000U);
  EXPECT_EQ(parts[1].bytes.size(), 1000U);
  part_size = 0;  // its lane is full
  EXPECT_TRUE(give(kDown, control::kListGet, {7, 0}));
  EXPECT_TRUE(sent.empty());
}

TEST_F(ListExchangeTest, ANewerListIsFetchedCheckedAndNotOlderOnes) {
  own(7);
  exchange.begin(now, kUp, true);
  EXPECT_TRUE(offer(kUp, 7));
  EXPECT_TRUE(offer(kUp, 6));
  EXPECT_TRUE(take(control::kListGet).empty());
  EXPECT_TRUE(offer(kUp, 8, 3000));
  auto gets = take(control::kListGet);
  ASSERT_EQ(gets.size(), 1U);
  EXPECT_EQ(gets[0].place, (ListPlace{8, 0}));
  EXPECT_TRUE(part(kUp, {8, 0}, 2000));
  EXPECT_TRUE(part(kUp, {8, 0}, 2000)) << "twice, because it was asked for twice";
  gets = take(control::kListGet);
  ASSERT_EQ(gets.size(), 1U);
  EXPECT_EQ(gets[0].place, (ListPlace{8, 2000}));
  EXPECT_TRUE(part(kUp, {8, 2000}, 1000));
  ASSERT_EQ(checks.size(), 1U);
  EXPECT_EQ(checks[0].number, 8U);
  EXPECT_EQ(checks[0].size, 3000U);
  exchange.on_checked(now, checks[0].transfer, true);
  EXPECT_TRUE(sent.empty()) << "it is not fetched again until it is in force";
  own(8);
  EXPECT_EQ(exchange.transfers(), 0U);
  EXPECT_EQ(exchange.next_timeout(), kNever);
}

TEST_F(ListExchangeTest, WhatIsNoMessageOfItIsRefused) {
  EXPECT_FALSE(offer(kUp, 3)) << "a link without keys";
  exchange.begin(now, kUp, true);
  EXPECT_FALSE(offer(kUp, 0));
  EXPECT_FALSE(offer(kUp, 3, 0));
  EXPECT_TRUE(offer(kUp, 3, ListExchange::kBytesMax));
  EXPECT_FALSE(offer(kUp, 3, ListExchange::kBytesMax + 1));
  EXPECT_FALSE(give(kUp, control::kList, {4, 100}, std::vector<std::byte>(1)));
  EXPECT_FALSE(give(kUp, control::kListGet, {4, 100}, std::vector<std::byte>(1)));
  EXPECT_FALSE(give(kUp, 9, {4, 100}));
  std::array<std::byte, kHeaderSize> empty{};
  EXPECT_FALSE(exchange.on_control(now, kUp, {.header = {.type = control::kList}, .bytes = empty}));
  // Parts have a size that makes progress.
  EXPECT_FALSE(part(kUp, {3, 0}, ListExchange::kPartMin - 1));
  EXPECT_TRUE(part(kUp, {3, 0}, ListExchange::kPartMin));
  EXPECT_TRUE(offer(kUp, 4, 1500));
  EXPECT_FALSE(part(kUp, {4, 0}, 1501));
  EXPECT_TRUE(part(kUp, {4, 0}, 1024));
  EXPECT_FALSE(part(kUp, {4, 1024}, 477));
  EXPECT_TRUE(part(kUp, {4, 1024}, 476)) << "the last one";
  EXPECT_EQ(checks.size(), 1U);
}

TEST_F(ListExchangeTest, ASilentNeighbourIsAskedAgainThenLeftAlone) {
  exchange.begin(now, kDown, false);
  EXPECT_TRUE(offer(kDown, 3));
  pass(ListExchange::kSilenceMax - 1ns);
  EXPECT_EQ(take(control::kListGet).size(), 5U);
  pass(ListExchange::kTimeMax);
  EXPECT_EQ(exchange.transfers(), 0U);
  EXPECT_TRUE(take(control::kListGet).empty());
  EXPECT_TRUE(offer(kDown, 4)) << "put aside all the same";
  EXPECT_TRUE(take(control::kListGet).empty());
  pass(1ns);
  EXPECT_EQ(take(control::kListGet).size(), 1U) << "a minute later";
}

// It sends just enough to look alive, and offers another list before one is complete.
TEST_F(ListExchangeTest, ANeighbourThatNeverFinishesHasAMinute) {
  exchange.begin(now, kDown, false);
  const Time began = now;
  std::uint64_t number = 1'000'000;
  for (int i = 0; i == 0 || exchange.transfers() > 0; ++i) {
    if (i % 8 == 0) number += 1;
    if (i % 4 == 0) {
      EXPECT_TRUE(offer(kDown, number, ListExchange::kBytesMax));
    }
    const auto gets = take(control::kListGet);
    ASSERT_FALSE(gets.empty());
    EXPECT_TRUE(part(kDown, gets.back().place, ListExchange::kPartMin));
    pass(4s);
  }
  EXPECT_LE(now, began + ListExchange::kTimeMax + 4s);
  sent.clear();
  EXPECT_TRUE(offer(kDown, number + 1));
  pass(ListExchange::kTimeMax - 5s);
  EXPECT_TRUE(sent.empty()) << "put aside";
  EXPECT_TRUE(checks.empty());
}

TEST_F(ListExchangeTest, OthersAndAboveAllTheLinkUpwardsAreNotDelayed) {
  for (std::uint32_t slot = 1; slot <= 6; ++slot) {
    exchange.begin(now, slot, false);
    EXPECT_TRUE(offer(slot, 1000 + slot));
  }
  EXPECT_EQ(exchange.transfers(), ListExchange::kAtOnce);
  sent.clear();
  exchange.begin(now, kUp, true);
  EXPECT_TRUE(offer(kUp, 2));
  EXPECT_EQ(exchange.transfers(), ListExchange::kAtOnce);
  const auto gets = take(control::kListGet);
  ASSERT_EQ(gets.size(), 1U);
  EXPECT_EQ(gets[0].slot, kUp);
  EXPECT_TRUE(part(kUp, {2, 0}, 100));
  ASSERT_EQ(checks.size(), 1U);
  exchange.on_checked(now, checks[0].transfer, true);
  own(2);
  // In the end everybody has had its turn.
  std::vector<bool> asked(7);
  for (int i = 0; i < 40; ++i) {
    pass(1s);
    for (const Sent& get : take(control::kListGet)) asked[get.slot] = true;
  }
  EXPECT_TRUE(std::ranges::all_of(asked.begin() + 1, asked.end(), [](bool is) { return is; }));
}

TEST_F(ListExchangeTest, AForgedListPutsItsSenderAside) {
  exchange.begin(now, kUp, true);
  exchange.begin(now, kDown, false);
  EXPECT_TRUE(offer(kUp, 9));
  EXPECT_TRUE(part(kUp, {9, 0}, 100));
  ASSERT_EQ(checks.size(), 1U);
  exchange.on_checked(now, checks[0].transfer, false);
  sent.clear();
  EXPECT_TRUE(offer(kUp, 10));
  EXPECT_TRUE(offer(kDown, 3));
  const auto gets = take(control::kListGet);
  ASSERT_EQ(gets.size(), 1U);
  EXPECT_EQ(gets[0].slot, kDown);
}

// Links that come and go do not add to the lists being verified.
TEST_F(ListExchangeTest, ListsBeingVerifiedAreBounded) {
  for (int i = 0; i < 20; ++i) {
    exchange.begin(now, kDown, false);
    EXPECT_TRUE(offer(kDown, 3));
    EXPECT_TRUE(part(kDown, {3, 0}, 100));
    exchange.end(now, kDown);
  }
  EXPECT_EQ(checks.size(), 1U) << "one of a link";
  exchange.on_checked(now, 99, true);
  exchange.on_checked(now, checks[0].transfer, false);
  EXPECT_EQ(exchange.transfers(), 0U);
}

TEST_F(ListExchangeTest, ATellThatFindsNoRoomComesLater) {
  part_size = 0;
  exchange.begin(now, kDown, false);
  own(3);
  EXPECT_TRUE(sent.empty());
  part_size = 1024;
  pass(ListExchange::kAskAgain);
  EXPECT_EQ(take(control::kList).size(), 1U);
}

}  // namespace list_exchange_test
}  // namespace tims::link
