#include "rack/proxies/proxy.h"

#include <array>

#include <gtest/gtest.h>

#include "rack/proxies/generic.h"

namespace rack {

namespace proxy_test {

using tims::Address;
using tims::Header;

constexpr Address kComponent(0x00110000);
constexpr i8 kAnswers[] = {-21};
constexpr Question kQuestion{kComponent, 7, kAnswers};

Header reply(i8 type, u8 seq_nr = 7, Address src = kComponent) {
  return {.type = type, .seq_nr = seq_nr, .src = src};
}

TEST(Answer, IsWhatWasAskedFor) { EXPECT_EQ(judge(kQuestion, reply(-21)), Verdict::kAnswer); }

TEST(Answer, OfSomebodyElseIsNone) {
  EXPECT_EQ(judge(kQuestion, reply(-21, 7, Address(0x00110001))), Verdict::kUnrelated);
  EXPECT_EQ(judge(kQuestion, reply(-1, 7, Address(0x00120000))), Verdict::kUnrelated);
}

TEST(Answer, ToAnEarlierRequestIsNone) {
  for (const i8 type : std::initializer_list<i8>{-21, -1, -2, -3}) {
    EXPECT_EQ(judge(kQuestion, reply(type, 6)), Verdict::kUnrelated);
  }
}

TEST(Answer, OfAnotherTypeIsNone) {
  EXPECT_EQ(judge(kQuestion, reply(0)), Verdict::kUnrelated);
  EXPECT_EQ(judge(kQuestion, reply(-6)), Verdict::kUnrelated);
}

TEST(Answer, Failures) {
  EXPECT_EQ(judge(kQuestion, reply(-1)), Verdict::kError);
  EXPECT_EQ(judge(kQuestion, reply(-2)), Verdict::kTimeout);
  EXPECT_EQ(judge(kQuestion, reply(-3)), Verdict::kNotAvailable);
}

TEST(Answer, ErrorIsAnAnswerWhereItIsAStatus) {
  static constexpr i8 kStates[] = {-4, -5, -1};
  EXPECT_EQ(judge({kComponent, 7, kStates}, reply(-1)), Verdict::kAnswer);
}

}  // namespace proxy_test

namespace proxy_test {

using tims::Address;
using tims::Errc;

constexpr Address kProducer(0x00140000);

struct Number {
  u32 value = 0;
};

tims::MessageView message(i8 type, std::span<const std::byte> body, Address src = kProducer) {
  return {{.flags = 0, .type = type, .src = src}, body};
}

TEST(Stream, DecodesInTheOrderOfTheHeader) {
  std::array<std::byte, 4> body{};
  body[3] = std::byte{5};
  Number number;
  ASSERT_TRUE(decode_data(message(-6, body), kProducer, number));
  EXPECT_EQ(number.value, 5U);
}

TEST(Stream, EndIsDistinguishedFromRubbish) {
  const std::array<std::byte, 4> body{};
  Number number;
  const auto code = [&](const tims::MessageView& m) {
    return decode_data(m, kProducer, number).error().code();
  };
  EXPECT_EQ(code(message(-1, {})), Errc::kAnsweredError);
  EXPECT_EQ(code(message(0, body)), Errc::kInvalidArgument);
  EXPECT_EQ(code(message(-6, body, Address(0x00150000))), Errc::kInvalidArgument);
  EXPECT_EQ(code(message(-6, std::span(body).first(3))), Errc::kMalformed);
}

TEST(Status, HasAName) {
  EXPECT_EQ(name(Status::kEnabled), "enabled");
  EXPECT_EQ(name(Status::kDisabled), "disabled");
  EXPECT_EQ(name(Status::kError), "error");
}

}  // namespace proxy_test

}  // namespace rack
