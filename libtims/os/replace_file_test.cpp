#include "os/replace_file.h"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "os/file.h"
#include "tests/support/temporary_folder.h"

namespace tims::os {
namespace replace_file_test {

mode_t mode_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mode & 07777;
}

TEST(ReplaceFile, MakesAFileAndKeepsTheModeOfAnOldOne) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  ASSERT_TRUE(replace_file(path, "one", 0640));
  EXPECT_EQ(mode_of(path), 0640U);
  ASSERT_EQ(::chmod(path.c_str(), 0604), 0);
  ASSERT_TRUE(replace_file(path, "two"));
  EXPECT_EQ(mode_of(path), 0604U);
  EXPECT_EQ(read_file(path).value(), "two");
}

TEST(ReplaceFile, WhatAnInterruptedAttemptLeftIsInNobodysWay) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  ASSERT_TRUE(replace_file(path + ".new", "half"));
  ASSERT_TRUE(replace_file(path, "whole"));
  EXPECT_EQ(read_file(path).value(), "whole");
  EXPECT_NE(::access((path + ".new").c_str(), F_OK), 0);
}

TEST(ReplaceFile, AnErrorNamesThePathAndLeavesTheOldFile) {
  const auto missing = replace_file("/no/such/folder/a", "x");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error(), Errc::kSystem);
  EXPECT_NE(missing.error().detail().find("/no/such/folder/a"), std::string::npos);
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "folder";
  ASSERT_EQ(::mkdir(path.c_str(), 0700), 0);
  EXPECT_FALSE(replace_file(path, "x")) << "a folder is not replaced";
  EXPECT_NE(::access((path + ".new").c_str(), F_OK), 0);
}

TEST(ReplaceFile, AReaderSeesTheOldOrTheNewText) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  const std::string texts[] = {std::string(40'000, 'a'), std::string(60'000, 'b')};
  ASSERT_TRUE(replace_file(path, texts[0]));
  std::atomic<bool> ended = false;
  std::thread reader([&] {
    while (!ended) {
      const auto text = read_file(path);
      EXPECT_TRUE(text && (*text == texts[0] || *text == texts[1]));
    }
  });
  for (int i = 1; i <= 100; ++i) EXPECT_TRUE(replace_file(path, texts[i % 2]));
  ended = true;
  reader.join();
}

TEST(RemoveFile, IsDoneWhenThereIsNone) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  ASSERT_TRUE(replace_file(path, "x"));
  EXPECT_TRUE(remove_file(path));
  EXPECT_NE(::access(path.c_str(), F_OK), 0);
  EXPECT_TRUE(remove_file(path));
}

}  // namespace replace_file_test
}  // namespace tims::os
