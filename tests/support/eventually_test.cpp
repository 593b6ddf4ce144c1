#include "tests/support/eventually.h"

#include <gtest/gtest.h>

namespace tims::test {
namespace eventually_test {

constexpr Duration kShort = std::chrono::milliseconds(5);

TEST(Eventually, HoldsAfterSomeTries) {
  int tries = 0;
  EXPECT_TRUE(eventually([&] { return ++tries == 3; }, "the third try"));
  EXPECT_EQ(tries, 3);
}

TEST(Eventually, ReportsWhatIsMissing) {
  const auto result = eventually([] { return false; }, "three mailboxes", kShort);
  EXPECT_FALSE(result);
  EXPECT_STREQ(result.message(), "after 5 ms: condition not met: three mailboxes");
}

TEST(Eventually, TheConditionMayExplainItself) {
  const auto result = eventually([]() -> std::string { return "2 of 3 are there"; }, kShort);
  EXPECT_FALSE(result);
  EXPECT_STREQ(result.message(), "after 5 ms: 2 of 3 are there");
  EXPECT_TRUE(eventually([]() -> std::string { return ""; }, kShort));
}

TEST(Eventually, ChecksOnceMoreAtTheDeadline) {
  EXPECT_TRUE(eventually([] { return true; }, "anything", Duration::zero()));
}

TEST(Eventually, PollsLessOftenTheLongerItTakes) {
  int tries = 0;
  const auto never = [&] { return ++tries < 0; };
  EXPECT_FALSE(eventually(never, "anything", std::chrono::milliseconds(500)));
  EXPECT_LT(tries, 40);
}

}  // namespace eventually_test
}  // namespace tims::test
