#include "proxies/gdos_files.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rack::gdos {
namespace {

TEST(GdosFiles, NamesCount) {
  EXPECT_EQ(numbered_file(17), "texts.000017.jsonl");
  EXPECT_EQ(file_number("texts.000017.jsonl"), 17U);
  EXPECT_EQ(file_number(numbered_file(12345678)), 12345678U);
  for (const char* other : {"texts.jsonl", "texts..jsonl", "texts.x.jsonl", "texts.1.json", "t"})
    EXPECT_FALSE(file_number(other)) << other;
}

TEST(GdosFiles, OldestFirst) {
  const tims::test::TemporaryFolder folder;
  EXPECT_TRUE(log_paths(folder.path()).empty());
  EXPECT_TRUE(log_paths(folder.path() / "nowhere").empty());
  EXPECT_EQ(log_files(folder.path()).next_number(), 1U);
  for (const char* name : {"texts.jsonl", "texts.000010.jsonl", "texts.000009.jsonl", "notes"})
    std::ofstream(folder.path() / name) << "";
  const auto paths = log_paths(folder.path());
  ASSERT_EQ(paths.size(), 3U);
  EXPECT_EQ(paths[0].filename(), "texts.000009.jsonl");
  EXPECT_EQ(paths[1].filename(), "texts.000010.jsonl");
  EXPECT_EQ(paths[2].filename(), "texts.jsonl");
  EXPECT_EQ(log_files(folder.path()).next_number(), 11U);
}

}  // namespace
}  // namespace rack::gdos
