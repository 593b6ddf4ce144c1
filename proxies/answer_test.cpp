#include "proxies/answer.h"

#include <gtest/gtest.h>

namespace rack {
namespace {

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

}  // namespace
}  // namespace rack
