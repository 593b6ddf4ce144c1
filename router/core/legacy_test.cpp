#include "router/core/legacy.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "wire/tcp_protocol.h"

namespace tims::core {
namespace legacy_test {

using Verb = LegacyCommand::Verb;
namespace command = wire::router_command;

LegacyCommand parse(std::int8_t type, std::uint8_t flags, std::vector<std::uint8_t> body) {
  std::vector<std::byte> bytes(kHeaderSize);
  for (const std::uint8_t b : body) bytes.push_back(std::byte{b});
  return parse_command({{.flags = flags, .type = type}, bytes});
}

TEST(Legacy, OnlyMessagesWithoutAnyAddressAreForTheRouter) {
  EXPECT_TRUE(is_for_router({}));
  EXPECT_FALSE(is_for_router({.dest = Address(1)}));
  EXPECT_FALSE(is_for_router({.src = Address(1)}));
  EXPECT_FALSE(is_for_router({.dest = Address(0x80000000), .src = Address(0x80000000)}));
}

TEST(Legacy, KnowsEveryCommand) {
  const std::array<std::pair<std::int8_t, Verb>, 8> commands{{{10, Verb::kLogin},
                                                              {15, Verb::kPurge},
                                                              {18, Verb::kEnableWatchdog},
                                                              {19, Verb::kDisableWatchdog},
                                                              {0, Verb::kAlive},
                                                              {64, Verb::kAdmin},
                                                              {16, Verb::kUnknown},
                                                              {-1, Verb::kUnknown}}};
  for (const auto& [type, verb] : commands) EXPECT_EQ(parse(type, 0, {}).verb, verb) << int{type};
}

TEST(Legacy, ReadsTheMailboxInBothOrders) {
  const LegacyCommand big = parse(command::kMailboxInitWithReply, 0x01, {3, 0x14, 0, 2});
  EXPECT_EQ(big.verb, Verb::kRegister);
  EXPECT_TRUE(big.wants_reply);
  EXPECT_EQ(big.mailbox, Address(0x03140002));
  const LegacyCommand little = parse(command::kMailboxDelete, 0x02, {2, 0, 0x14, 3, 99});
  EXPECT_EQ(little.verb, Verb::kDelete);
  EXPECT_FALSE(little.wants_reply);
  EXPECT_EQ(little.mailbox, Address(0x03140002));
}

TEST(Legacy, AClientMayAskForTheNewestSamplesOnly) {
  const auto keeps = [](std::int8_t type, std::vector<std::uint8_t> body) {
    return parse(type, 0, std::move(body)).keeps_newest;
  };
  EXPECT_TRUE(keeps(command::kMailboxInitWithReply, {3, 0x14, 0, 2, 0, 0, 0, 1}));
  EXPECT_TRUE(keeps(command::kMailboxInit, {3, 0x14, 0, 2, 0, 0, 0, 1}));
  EXPECT_FALSE(keeps(command::kMailboxInit, {3, 0x14, 0, 2}));
  EXPECT_FALSE(keeps(command::kMailboxInit, {3, 0x14, 0, 2, 0, 0, 0}));
  EXPECT_FALSE(keeps(command::kMailboxInit, {3, 0x14, 0, 2, 0, 0, 0, 1, 0}));
  EXPECT_FALSE(keeps(command::kMailboxInit, {3, 0x14, 0, 2, 0, 0, 0, 3})) << "unknown options";
  EXPECT_EQ(parse(command::kMailboxInit, 0x02, {2, 0, 0x14, 3, 1, 0, 0, 0}).keeps_newest, true);
  EXPECT_EQ(parse(command::kMailboxInit, 0, {3, 0x14, 0, 2, 0, 0, 0, 1}).mailbox,
            Address(0x03140002));
}

TEST(Legacy, AMailboxOfLessThanFourBytesIsNone) {
  for (const std::int8_t type :
       {command::kMailboxInit, command::kMailboxDelete, command::kMailboxInitWithReply,
        command::kMailboxDeleteWithReply}) {
    EXPECT_EQ(parse(type, 0, {}).verb, Verb::kMalformed);
    EXPECT_EQ(parse(type, 0, {1, 2, 3}).verb, Verb::kMalformed);
  }
}

// The original's C library answers any message of type 17 with OK to the router.
TEST(Legacy, ALifesignFromAClientIsNoCommand) {
  EXPECT_EQ(parse(command::kLifesign, 0, {1, 2, 3, 4}).verb, Verb::kUnknown);
}

using namespace std::chrono_literals;
using Beat = Lifesigns::Beat;

class LifesignsTest : public testing::Test {
 protected:
  const Time start_{1000s};
  Lifesigns lifesigns_{5s};
  Client client_;
  Client other_;
};

TEST_F(LifesignsTest, BeatOnlyWhileSomebodyIsWatched) {
  EXPECT_EQ(lifesigns_.next_beat(), kNever);
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.watch(start_ + 1s, client_);
  lifesigns_.watch(start_ + 1s, other_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.unwatch(client_);
  lifesigns_.unwatch(client_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.unwatch(other_);
  EXPECT_EQ(lifesigns_.next_beat(), kNever);
  EXPECT_EQ(lifesigns_.beat(start_ + 60s), Beat::kNotYet);
}

TEST_F(LifesignsTest, KeepsItsRhythm) {
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.beat(start_ + 4999ms), Beat::kNotYet);
  EXPECT_EQ(lifesigns_.beat(start_ + 5003ms), Beat::kAsk);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 10s);
}

TEST_F(LifesignsTest, ALateBeatIsKnownAsSuchAndStartsANewRhythm) {
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.beat(start_ + 20s), Beat::kLate);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 25s);
}

TEST_F(LifesignsTest, WatchingAndUnwatchingClearTheMark) {
  lifesigns_.watch(start_, client_);
  client_.owes_answer = true;
  lifesigns_.watch(start_, client_);
  EXPECT_FALSE(client_.owes_answer);
  client_.owes_answer = true;
  lifesigns_.unwatch(client_);
  EXPECT_FALSE(client_.owes_answer);
}

TEST_F(LifesignsTest, ALongerIntervalHoldsFromTheNextBeatOn) {
  lifesigns_.watch(start_, client_);
  lifesigns_.set_interval(start_, 60s);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  EXPECT_EQ(lifesigns_.beat(start_ + 5s), Beat::kAsk);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 65s);
}

}  // namespace legacy_test
}  // namespace tims::core
