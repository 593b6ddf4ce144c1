#include "components/files/whole_file.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_FALSE(fs::exists(path + ".new"));
  const auto nowhere = write_file(folder.path() / "missing" / "file", "x");
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error().detail(), testing::HasSubstr("No such file"));
}

}  // namespace whole_file_test
}  // namespace rack
