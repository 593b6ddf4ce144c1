#include "router/config/substitute.h"

#include <gtest/gtest.h>

namespace tims::config {
namespace {

const Environment kEnvironment{{"HOSTNAME", "robot1"}, {"EMPTY", ""}, {"NESTED", "${HOSTNAME}"}};

std::string replaced(std::string_view text) {
  const auto result = substitute(text, kEnvironment);
  return result ? *result : "refused: " + result.error().detail();
}

TEST(Substitute, ReplacesVariables) {
  EXPECT_EQ(replaced("${HOSTNAME}"), "robot1");
  EXPECT_EQ(replaced("/run/${HOSTNAME}/${HOSTNAME}.sock"), "/run/robot1/robot1.sock");
  EXPECT_EQ(replaced("a${EMPTY}b"), "ab");
}

TEST(Substitute, LeavesOtherTextAlone) {
  EXPECT_EQ(replaced(""), "");
  EXPECT_EQ(replaced("plain {text}"), "plain {text}");
  EXPECT_EQ(replaced("$HOSTNAME costs 5$"), "$HOSTNAME costs 5$");
}

TEST(Substitute, TwoDollarsAreOne) {
  EXPECT_EQ(replaced("$${HOSTNAME}"), "${HOSTNAME}");
  EXPECT_EQ(replaced("$$"), "$");
  EXPECT_EQ(replaced("$$$${"), "$${");
}

TEST(Substitute, ReplacesOnlyOnce) { EXPECT_EQ(replaced("${NESTED}"), "${HOSTNAME}"); }

TEST(Substitute, RefusesWhatItCannotReplace) {
  EXPECT_EQ(replaced("${ROBOT}"),
            "refused: names the environment variable ROBOT, which is not set");
  EXPECT_EQ(replaced("${}"), "refused: names the environment variable , which is not set");
  EXPECT_EQ(replaced("x${HOSTNAME"), "refused: has ${ without }; a dollar sign is written $$");
}

}  // namespace
}  // namespace tims::config
