#include "tools/configuration/differences.h"

#include <random>

#include <gtest/gtest.h>

namespace timsctl::configuration {
namespace differences_test {

TEST(Difference, EqualTextsHaveNone) {
  const TextDifference none = difference("f", "a\nb\n", "a\nb\n");
  EXPECT_EQ(none.diff, "");
  EXPECT_EQ(none.added + none.removed, 0U);
}

TEST(Difference, IsUnifiedWithThreeLinesAround) {
  const TextDifference made =
      difference("f", "1\n2\n3\n4\n5\n6\n7\n8\n9\n", "1\n2\n3\n4\nx\n6\n7\n8\n9\n");
  EXPECT_EQ(made.diff, "--- f\n+++ f\n@@ -2,7 +2,7 @@\n 2\n 3\n 4\n-5\n+x\n 6\n 7\n 8\n");
  EXPECT_EQ(made.added, 1U);
  EXPECT_EQ(made.removed, 1U);
}

TEST(Difference, FarChangesAreBlocksOfTheirOwn) {
  std::string before;
  for (int i = 1; i <= 30; ++i) before += std::to_string(i) + "\n";
  std::string after = "0\n" + before;
  after.erase(after.find("29\n"), 3);
  EXPECT_EQ(difference("f", before, after).diff,
            "--- f\n+++ f\n@@ -1,3 +1,4 @@\n+0\n 1\n 2\n 3\n@@ -26,5 +27,4 @@\n 26\n 27\n "
            "28\n-29\n 30\n");
}

TEST(Difference, NewAndRemovedFilesAndMissingLineEnds) {
  EXPECT_EQ(difference("f", "", "a\n").diff, "--- f\n+++ f\n@@ -0,0 +1,1 @@\n+a\n");
  EXPECT_EQ(difference("f", "a\n", "").diff, "--- f\n+++ f\n@@ -1,1 +0,0 @@\n-a\n");
  EXPECT_EQ(difference("f", "a", "b\n").diff,
            "--- f\n+++ f\n@@ -1,1 +1,1 @@\n-a\n\\ No newline at end of file\n+b\n");
}

TEST(Difference, LargeTextsAreDoneInBoundedTime) {
  std::string before;
  std::string after;
  for (int i = 0; i < 30'000; ++i) before += "\n", after += "x\n";
  const TextDifference made = difference("f", before, after);
  EXPECT_EQ(made.removed, 30'000U);
  EXPECT_EQ(made.added, 30'000U);
}

TEST(Difference, CountsWhatAnEditorChanged) {
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    std::vector<std::string> lines(random() % 40, "same\n");
    for (std::string& line : lines) line = std::to_string(random() % 1000) + "\n";
    std::string before;
    std::string after;
    std::size_t changed = 0;
    for (const std::string& line : lines) {
      before += line;
      const bool is_changed = random() % 5 == 0;
      changed += is_changed ? 1 : 0;
      after += is_changed ? "changed " + line : line;
    }
    const TextDifference made = difference("f", before, after);
    EXPECT_EQ(made.added, changed);
    EXPECT_EQ(made.removed, changed);
  }
}

}  // namespace differences_test
}  // namespace timsctl::configuration
