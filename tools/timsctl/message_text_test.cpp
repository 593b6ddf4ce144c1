#include "tools/timsctl/message_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/values.h"

namespace timsctl {
namespace {

using testing::HasSubstr;

Message message(std::size_t bytes, std::uint8_t flags = tims::flag::kBodyLittleEndian) {
  Message m{.header = {.flags = flags,
                       .type = -6,
                       .priority = 200,
                       .seq_nr = 9,
                       .dest = tims::Address(0x030F0709),
                       .src = tims::Address(0x03140000),
                       .length = static_cast<std::uint32_t>(16 + bytes)},
            .body = {}};
  // Every value, also those that look like marks of the format: '-', '|', '.', blanks.
  for (std::size_t i = 0; i < bytes; ++i) m.body.push_back(static_cast<std::byte>(i * 7));
  return m;
}
constexpr WallTime kTime(std::chrono::seconds(1'800'000'000));

void expect_same(const Draft& draft, const Message& m) {
  EXPECT_EQ(draft.type, m.header.type);
  EXPECT_EQ(draft.priority, m.header.priority);
  EXPECT_EQ(draft.seq_nr, m.header.seq_nr);
  EXPECT_EQ(draft.little_endian, m.header.body_order() == std::endian::little);
  EXPECT_EQ(draft.body, m.body);
}

std::string refusal(const std::string& text) {
  try {
    (void)parse_recorded(text);
  } catch (const Failure& failure) {
    return failure.message;
  }
  return "accepted";
}

TEST(MessageText, LooksLikeThis) {
  Message m = message(0);
  m.body = *parse_hex("01 02 41 42");
  EXPECT_EQ(dump(m, kTime, {.utc = true}),
            "-- 08:00:00.000Z Ladar(3/0) -> Tool(3/7):9 type=-6 (data) priority=200 seq=9 "
            "order=little bytes=4\n"
            "   0000  01 02 41 42                                       |..AB|\n");
}

TEST(MessageText, AddressesAreDividedAsTheFleetDoes) {
  constexpr tims::AddressWidths kWidths{6, 8, 10, 8};
  Message m = message(0);
  m.header.src = tims::Address::of({.system = 3, .class_id = 0x14, .instance = 500}, kWidths);
  EXPECT_THAT(dump(m, kTime, {.widths = kWidths}), HasSubstr(" Ladar(3/500) -> "));
  EXPECT_EQ(text_at(message_json(m, kTime, kWidths), "src.name"), "Ladar(3/500)");
}

TEST(MessageText, WhatIsWrittenCanBeRead) {
  for (const std::size_t bytes : {0U, 1U, 15U, 16U, 17U, 1000U, 70'000U}) {
    const Message m = message(bytes);
    const std::string text = dump(m, kTime, {});
    ASSERT_TRUE(is_recorded(text));
    const auto drafts = parse_recorded(text);
    ASSERT_EQ(drafts.size(), 1U);
    expect_same(drafts[0], m);
  }
}

TEST(MessageText, SeveralMessagesAndBothOrders) {
  const Message big = message(20, 0);
  const auto drafts = parse_recorded(dump(message(40), kTime, {}) + dump(big, kTime, {}));
  ASSERT_EQ(drafts.size(), 2U);
  expect_same(drafts[1], big);
}

TEST(MessageText, JsonCanBeReadToo) {
  const Message m = message(40, 0);
  const std::string lines = to_text(message_json(m, kTime, {})) + "\n" +
                            to_text(message_json(message(3), kTime, {})) + "\n";
  ASSERT_TRUE(is_recorded(lines));
  const auto drafts = parse_recorded(lines);
  ASSERT_EQ(drafts.size(), 2U);
  expect_same(drafts[0], m);
  expect_same(drafts[1], message(3));
}

TEST(MessageText, ABodyInDotsIsNotAShortenedOne) {
  Message m = message(0);
  m.body = *parse_hex("2e2e2e20 2e2e2e20 2e2e2e20 2e2e2e20");
  expect_same(parse_recorded(dump(m, kTime, {})).at(0), m);
}

TEST(MessageText, ShortenedForATerminalIsRefused) {
  const std::string text = dump(message(100), kTime, {.bytes_max = 32});
  EXPECT_THAT(text, HasSubstr("... 68 more bytes"));
  EXPECT_THAT(refusal(text), HasSubstr("shortened"));
}

TEST(MessageText, DamageIsRefusedWithTheLine) {
  const std::string good = dump(message(20), kTime, {});
  EXPECT_THAT(refusal(good.substr(0, good.rfind("   0010"))), HasSubstr("16 bytes, not 20"));
  std::string no_type = good;
  no_type.replace(no_type.find(" type="), 6, " tipe=");
  EXPECT_THAT(refusal(no_type), HasSubstr("line 1"));
  EXPECT_THAT(refusal(good + "what is this?\n"), HasSubstr("line 4"));
  EXPECT_THAT(refusal("{\"schema\":\"tims/message/1\",\"type\":300,\"body_hex\":\"\"}"),
              HasSubstr("line 1"));
  EXPECT_THAT(refusal("{\"schema\":\"tims/message/1\",\"type\":1,\"body_hex\":\"0\"}"),
              HasSubstr("line 1"));
}

TEST(MessageText, OtherFilesAreBodies) {
  EXPECT_FALSE(is_recorded(""));
  EXPECT_FALSE(is_recorded("--- a patch"));
  EXPECT_FALSE(is_recorded("{\"a\":1}"));
}

}  // namespace
}  // namespace timsctl
