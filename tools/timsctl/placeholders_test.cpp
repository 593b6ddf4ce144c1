#include "tools/timsctl/placeholders.h"

#include <array>

#include <gtest/gtest.h>

namespace timsctl {
namespace {

const Placeholders kValues = {{"robot", "robot1"}, {"host", "robot1-arm"}, {"system", "1"}};
const std::array<std::string, 2> kKnown = {"host", "system"};

TEST(Placeholders, AreFilledIn) {
  EXPECT_EQ(filled_in("{robot}/{host}:{system}.", kValues), "robot1/robot1-arm:1.");
  EXPECT_EQ(filled_in("{system}{system}", kValues), "11");
  EXPECT_EQ(filled_in("a{x}b", kValues), "ab") << "not known";
  EXPECT_EQ(filled_in("", kValues), "");
}

TEST(Placeholders, OfOthersAreFound) {
  EXPECT_EQ(unknown_placeholder("{host} {x} {y}", kKnown), "x");
  EXPECT_EQ(unknown_placeholder("{}", kKnown), "");
  EXPECT_EQ(unknown_placeholder("{host} and {system}", kKnown), std::nullopt);
}

TEST(Placeholders, ABraceAloneIsItself) {
  for (const char* text : {"{", "}", "}{", "{system"}) {
    EXPECT_EQ(unknown_placeholder(text, kKnown), std::nullopt) << text;
    EXPECT_EQ(filled_in(text, kValues), text);
  }
}

}  // namespace
}  // namespace timsctl
