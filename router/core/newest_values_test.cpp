#include "router/core/newest_values.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "router/core/router_fixture.h"

namespace tims::core::test {
namespace newest_values_test {

constexpr Address kPosition{0x03130000};
constexpr Address kLadar{0x03140000};
constexpr std::uint8_t kSample = flag::kNativeOrder | flag::kStream;

NewestRule rule() {
  NewestRule rule{.length_max = 4096};
  for (const char* element : {"status", "parameters", "Position", "Path"})
    EXPECT_TRUE(rule.add(element));
  return rule;
}

class NewestValuesTest : public testing::Test {
 protected:
  NewestValuesTest() { values_.set_rule(rule()); }

  static Time at(int seconds) { return Time(std::chrono::seconds(seconds)); }
  static Bytes body(std::size_t size, int mark) { return {size, static_cast<std::byte>(mark)}; }

  void keep(int seconds, Header header, const Bytes& content) {
    Bytes bytes = encoded(header, content);
    header = wire::decode_header(std::span(bytes).first<kHeaderSize>());
    ASSERT_TRUE(values_.wants(header));
    values_.keep(at(seconds), {header, bytes});
  }
  void keep_sample(int seconds, Address source, const Bytes& content) {
    keep(seconds, {.flags = kSample, .type = type::kData, .src = source}, content);
  }
  [[nodiscard]] Bytes kept(Address source, StreamKind kind = StreamKind::kData) const {
    const auto* value = values_.find(source, kind);
    return value == nullptr ? Bytes() : values_.body(*value);
  }

  NewestValues values_{16 << 10, {1, 2}};  // 16 values, 64 cells
};

TEST_F(NewestValuesTest, WantsTheListedStreamsOnly) {
  const auto wants = [&](std::int8_t type, Address source, std::uint8_t flags = kSample) {
    return values_.wants({.flags = flags, .type = type, .src = source});
  };
  EXPECT_TRUE(wants(type::kData, kPosition));
  EXPECT_TRUE(wants(type::kData, kPosition, flag::kReportIfGone))
      << "must not be replaced on a link";
  EXPECT_FALSE(wants(type::kData, kPosition, flag::kNativeOrder)) << "an answer may be older";
  EXPECT_FALSE(wants(type::kData, kLadar));
  EXPECT_TRUE(wants(type::kEnabled, kLadar, 0));
  EXPECT_TRUE(wants(type::kDisabled, kLadar, 0));
  EXPECT_TRUE(wants(type::kParam, kLadar, 0));
  EXPECT_FALSE(wants(type::kError, kLadar, 0));
  EXPECT_FALSE(wants(type::kOn, kPosition));
  values_.set_rule({});
  EXPECT_FALSE(wants(type::kData, kPosition));
  EXPECT_FALSE(wants(type::kEnabled, kLadar, 0));
}

TEST_F(NewestValuesTest, ClassesAreReadAtTheWidthsOfTheFleet) {
  NewestRule wide = rule();
  wide.widths = {12, 8, 6, 6};
  values_.set_rule(wide);
  const auto position = Address::of({.system = 300, .class_id = class_id::kPosition}, wide.widths);
  EXPECT_TRUE(values_.wants({.flags = kSample, .type = type::kData, .src = position}));
  EXPECT_FALSE(values_.wants({.flags = kSample, .type = type::kData, .src = kPosition}));
  // A class id that the rule cannot list.
  wide.widths = {8, 16, 4, 4};
  wide.classes.set();
  values_.set_rule(wide);
  const auto strange = Address::of({.class_id = 256}, wide.widths);
  EXPECT_FALSE(values_.wants({.flags = kSample, .type = type::kData, .src = strange}));
}

TEST_F(NewestValuesTest, RulesKnowTheirWords) {
  NewestRule all;
  EXPECT_TRUE(all.add("*"));
  EXPECT_TRUE(all.classes.all());
  EXPECT_FALSE(all.status);
  NewestRule state;
  EXPECT_TRUE(state.add("state"));
  EXPECT_TRUE(state.classes[class_id::kPosition]);
  EXPECT_FALSE(state.classes[class_id::kLadar]);
  for (const char* wrong : {"", "Position(1/0)", "**", "data"})
    EXPECT_FALSE(all.add(wrong)) << wrong;
}

TEST_F(NewestValuesTest, ANewerValueReplacesTheOlder) {
  keep_sample(1, kPosition, body(500, 1));
  keep_sample(3, kPosition, body(20, 2));
  const auto* value = values_.find(kPosition, StreamKind::kData);
  ASSERT_NE(value, nullptr);
  EXPECT_EQ(value->at, at(3));
  EXPECT_EQ(value->samples, 2U);
  EXPECT_EQ(values_.body(*value), body(20, 2));
  EXPECT_EQ(values_.counts().values, 1U);
  EXPECT_EQ(values_.counts().bytes, 20U);
  EXPECT_EQ(values_.counts().added, 1U);
  EXPECT_EQ(values_.counts().replaced, 1U);
}

TEST_F(NewestValuesTest, StatusAndParametersAreStreamsOfTheirOwn) {
  keep_sample(1, kPosition, body(8, 1));
  keep(2, {.type = type::kEnabled, .src = kPosition}, {});
  keep(3, {.type = type::kParam, .src = kPosition}, body(9, 3));
  keep(4, {.type = type::kDisabled, .src = kPosition}, {});
  const auto* status = values_.find(kPosition, StreamKind::kStatus);
  ASSERT_NE(status, nullptr);
  EXPECT_EQ(status->header.type, type::kDisabled);
  EXPECT_EQ(status->samples, 2U);
  EXPECT_EQ(kept(kPosition), body(8, 1));
  EXPECT_EQ(kept(kPosition, StreamKind::kParameters), body(9, 3));
  EXPECT_EQ(values_.counts().values, 3U);
}

TEST_F(NewestValuesTest, TheLimitOfAMessageIncludesItsHeader) {
  keep_sample(1, kPosition, body(4096 - kHeaderSize, 1));
  EXPECT_EQ(values_.counts().too_big, 0U);
  keep_sample(2, kPosition, body(4097 - kHeaderSize, 2));
  EXPECT_EQ(values_.counts().too_big, 1U);
  EXPECT_EQ(kept(kPosition), body(4096 - kHeaderSize, 1)) << "the older one stays, with its age";
}

TEST_F(NewestValuesTest, WhatIsLargerThanAllMemoryIsNotKept) {
  NewestRule large = rule();
  large.length_max = 1 << 20;
  values_.set_rule(large);
  keep_sample(1, kPosition, body(64 * 252, 1));
  EXPECT_EQ(kept(kPosition).size(), 64U * 252);
  keep_sample(2, kPosition, body(64 * 252 + 1, 2));
  EXPECT_EQ(values_.counts().too_big, 1U);
}

TEST_F(NewestValuesTest, TheValueThatWasNotRenewedForTheLongestTimeMakesRoom) {
  for (std::uint32_t i = 0; i < 16; ++i) keep_sample(1, Address(kPosition.raw() + i), body(10, 1));
  keep_sample(2, kPosition, body(10, 2));
  EXPECT_EQ(values_.counts().evicted, 0U);
  keep_sample(3, Address(kPosition.raw() + 16), body(10, 3));
  EXPECT_EQ(values_.counts().values, 16U);
  EXPECT_EQ(values_.counts().evicted, 1U);
  EXPECT_EQ(values_.find(Address(kPosition.raw() + 1), StreamKind::kData), nullptr);
  EXPECT_NE(values_.find(kPosition, StreamKind::kData), nullptr);
}

TEST_F(NewestValuesTest, ALargeValueMayTakeTheRoomOfSeveralButNotItsOwn) {
  for (std::uint32_t i = 0; i < 4; ++i)
    keep_sample(1, Address(kPosition.raw() + i), body(std::size_t{16} * 252, 1));
  keep_sample(2, kPosition, body(16 * 252, 2));
  EXPECT_EQ(values_.counts().evicted, 0U) << "its own room is enough";
  NewestRule large = rule();
  large.length_max = 1 << 20;
  values_.set_rule(large);
  keep_sample(3, kPosition, body(40 * 252, 3));
  EXPECT_EQ(values_.counts().evicted, 2U);
  EXPECT_EQ(kept(kPosition), body(40 * 252, 3));
}

TEST_F(NewestValuesTest, ListsThoseThatMatchInOrder) {
  keep_sample(1, Address(0x04130000), body(1, 1));
  keep_sample(2, kPosition, body(1, 1));
  keep(3, {.type = type::kEnabled, .src = kPosition}, {});
  keep(4, {.type = type::kEnabled, .src = kLadar}, {});
  const auto all = values_.sorted(*AddressPattern::parse("*(3/*)"));
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0]->kind, StreamKind::kData);
  EXPECT_EQ(all[1]->kind, StreamKind::kStatus);
  EXPECT_EQ(all[2]->header.src, kLadar);
}

// Against a model that keeps everything: what is kept is always the newest.
TEST_F(NewestValuesTest, NeverMixesValues) {
  std::mt19937 random(7);
  std::map<std::uint32_t, Bytes> model;
  for (int i = 0; i < 20000; ++i) {
    const Address source(kPosition.raw() + static_cast<std::uint32_t>(random() % 24));
    const Bytes content = body(random() % 2000, static_cast<int>(random() % 256));
    keep_sample(i, source, content);
    model[source.raw()] = content;
    if (i % 50 != 0) continue;
    std::uint64_t bytes = 0;
    for (const auto* value : values_.sorted({})) {
      ASSERT_EQ(values_.body(*value), model.at(value->header.src.raw()));
      bytes += value->header.body_size();
    }
    ASSERT_EQ(values_.counts().bytes, bytes);
    ASSERT_LE(bytes, values_.counts().bytes_max);
  }
  EXPECT_GT(values_.counts().evicted, 0U);
}

// --- in the router

class NewestOfRouterTest : public RouterTest {
 protected:
  NewestOfRouterTest() {
    values_.set_rule(rule());
    router_.keep_newest(values_);
  }
  Outcome send_sample(ClientId from) {
    return send(from, {.flags = kSample, .type = type::kData, .dest = Address(5), .src = kPosition},
                bytes_of("here"));
  }
  NewestValues values_{16 << 10, {1, 2}};
};

TEST_F(NewestOfRouterTest, WhatPassesIsKeptWithItsSourceGone) {
  const ClientId robot =
      link(LinkKind::kSub, static_cast<std::uint8_t>(kPosition.raw() >> 24), "robot");
  router_.learn(now_, robot, kPosition, {Address(0x03000100), 1, 1});
  EXPECT_EQ(send_sample(robot), Outcome::kNoRoute) << "also without a receiver";
  router_.disconnect(now_, robot, CloseReason::kSilent);
  const auto* value = values_.find(kPosition, StreamKind::kData);
  ASSERT_NE(value, nullptr);
  EXPECT_EQ(value->at, now_);
  EXPECT_EQ(values_.body(*value), bytes_of("here"));
  EXPECT_NE(value->header.flags & flag::kStream, 0);
}

TEST_F(NewestOfRouterTest, OnlyTheOwnerOfAnAddressHasValues) {
  const ClientId owner = connect(PortKind::kWebSocket);
  const ClientId forger = connect(PortKind::kTcp);
  router_.register_mailbox(now_, owner, kPosition);
  send_sample(forger);
  EXPECT_EQ(values_.find(kPosition, StreamKind::kData), nullptr);
  send_sample(owner);
  EXPECT_NE(values_.find(kPosition, StreamKind::kData), nullptr);
}

}  // namespace newest_values_test
}  // namespace tims::core::test
