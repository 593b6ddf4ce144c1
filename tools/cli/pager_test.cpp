#include "tools/cli/pager.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace timsctl {
namespace pager_test {

TEST(Pager, CountsRows) {
  EXPECT_EQ(rows_of("", 80), 0U);
  EXPECT_EQ(rows_of("one", 80), 1U);
  EXPECT_EQ(rows_of("one\n", 80), 1U);
  EXPECT_EQ(rows_of("one\n\ntwo\n", 80), 3U);
  EXPECT_EQ(rows_of(std::string(80, 'x') + "\n", 80), 1U);
  EXPECT_EQ(rows_of(std::string(81, 'x') + "\n", 80), 2U) << "the terminal wraps it";
  EXPECT_EQ(rows_of("\033[31m" + std::string(80, 'x') + "\033[0m\n", 80), 1U) << "colours";
  EXPECT_EQ(rows_of(std::string(200, 'x'), 0), 1U) << "unknown width";
}

TEST(Pager, NoneWithoutATerminal) {
  if (::isatty(STDIN_FILENO) != 0) GTEST_SKIP() << "stdin is a terminal";
  EXPECT_FALSE(show_in_pager(std::string(10'000, '\n')));
}

}  // namespace pager_test
}  // namespace timsctl
