#include "components/files/whole_file.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "os/file.h"
#include "tests/support/temporary_folder.h"

namespace rack {
namespace whole_file_test {

namespace fs = std::filesystem;

TEST(WholeFile, ReplacesTheOldContents) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "map.yaml";
  for (const char* contents : {"old and longer", "new"}) {
    ASSERT_TRUE(write_file(path, contents));
    EXPECT_EQ(tims::os::read_file(path).value(), contents);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(WholeFile, AnErrorNamesTheFileAndLeavesNoOther) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "folder";
  fs::create_directories(folder.path() / "folder" / "in it");
  const auto on_folder = write_file(path, "x");
  ASSERT_FALSE(on_folder);
  EXPECT_THAT(on_folder.error().detail(), testing::HasSubstr(path));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  const auto nowhere = write_file(folder.path() / "missing" / "file", "x");
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error().detail(), testing::HasSubstr("No such file"));
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 07777;
}

TEST(WholeFile, KeepsTheModeOfAnExistingFile) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "map.dxf";
  ASSERT_TRUE(write_file(path, "new"));
  for (const mode_t mode : {0600, 0640, 0755, 0400}) {
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
    ASSERT_TRUE(write_file(path, "newer"));
    EXPECT_EQ(mode_of(path), mode);
  }
}

// A hard link or a symbolic link shares nothing with the new file.
TEST(WholeFile, IsNeverWrittenThroughALink) {
  const tims::test::TemporaryFolder folder;
  const std::string other = folder.path() / "other";
  const std::string link = folder.path() / "link";
  const std::string hard = folder.path() / "hard";
  std::ofstream(other) << "keep";
  fs::create_symlink(other, link);
  fs::create_hard_link(other, hard);
  ASSERT_TRUE(write_file(link, "new"));
  ASSERT_TRUE(write_file(hard, "new"));
  EXPECT_EQ(tims::os::read_file(other).value(), "keep");
  EXPECT_FALSE(fs::is_symlink(link));
}

// Nothing of /dev is tried here: a program of root that does replace it would damage this host.
TEST(WholeFile, WhatIsNoRegularFileIsNotReplaced) {
  const tims::test::TemporaryFolder folder;
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto written = write_file(pipe, "x");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().detail(), pipe + ": is not a file; use another name");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

}  // namespace whole_file_test
}  // namespace rack
