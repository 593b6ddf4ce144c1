#include "components/files/file_folder.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace rack {
namespace file_folder_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(FileFolder, NamesThatStayInIt) {
  for (const std::string_view good :
       {"a", "map.dxf", "run 1_scan2d_0.dat", "a..b", "Saal-\xc3\xa4.dxf"})
    EXPECT_TRUE(is_plain_name(good)) << good;
  EXPECT_TRUE(is_plain_name(std::string(200, 'x')));
  EXPECT_FALSE(is_plain_name(std::string(201, 'x')));
  using namespace std::string_view_literals;
  for (const std::string_view bad :
       {""sv, "."sv, ".."sv, ".bashrc"sv, "/"sv, "/etc/passwd"sv, "../a"sv, "a/b"sv, "a/"sv,
        "a\0b"sv, "a\nb"sv, "a\x1b[2J"sv, "a\x7f"sv})
    EXPECT_FALSE(is_plain_name(bad)) << bad;
}

class FileFolderTest : public testing::Test {
 protected:
  [[nodiscard]] std::string content(const std::string& name) const {
    return tims::os::read_file(folder_.path() / "files" / name).value_or("unreadable");
  }

  tims::test::TemporaryFolder folder_;
  const FileFolder files_{(folder_.path() / "files").string()};
};

TEST_F(FileFolderTest, IsMadeByTheFirstFile) {
  EXPECT_FALSE(files_.existing("map.dxf"));
  EXPECT_FALSE(fs::exists(files_.path()));
  ASSERT_TRUE(files_.write("map.dxf", "lines"));
  EXPECT_EQ(content("map.dxf"), "lines");
  EXPECT_EQ(files_.existing("map.dxf").value(), files_.path_of("map.dxf"));
  auto log = files_.create("c.dat");
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(::write(log->get(), "one\n", 4), 4);
  EXPECT_EQ(content("c.dat"), "one\n");
}

TEST_F(FileFolderTest, NothingOutsideOfItIsTouched) {
  ASSERT_TRUE(files_.write("map.dxf", "lines"));
  const std::string outside = folder_.path() / "secret";
  std::ofstream(outside) << "keep";
  ASSERT_EQ(::chmod(outside.c_str(), 0600), 0);
  fs::create_symlink(outside, fs::path(files_.path()) / "link");
  fs::create_symlink("/nowhere", fs::path(files_.path()) / "dangling");
  fs::create_directory(fs::path(files_.path()) / "folder");
  ASSERT_EQ(::mkfifo(files_.path_of("pipe").c_str(), 0600), 0);
  for (const std::string& name :
       {std::string("link"), std::string("dangling"), std::string("folder"), std::string("pipe"),
        outside, std::string("../secret"), std::string("folder/../map.dxf")}) {
    EXPECT_FALSE(files_.write(name, "x")) << name;
    EXPECT_FALSE(files_.create(name)) << name;
    EXPECT_FALSE(files_.existing(name)) << name;
  }
  EXPECT_EQ(tims::os::read_file(outside).value(), "keep");
  EXPECT_FALSE(fs::exists("/nowhere"));
  EXPECT_EQ(content("map.dxf"), "lines");
}

TEST_F(FileFolderTest, RefusalsNameTheReason) {
  ASSERT_TRUE(files_.write("map.dxf", "lines"));
  fs::create_symlink("map.dxf", fs::path(files_.path()) / "link");
  EXPECT_THAT(files_.write("link", "x").error().detail(), HasSubstr("link: is a link"));
  EXPECT_EQ(files_.write("../a\n", "x").error().detail(),
            "\"../a?\": a message can name only a file in " + files_.path() +
                ", without a path; not a hidden one");
}

TEST_F(FileFolderTest, ModesStay) {
  for (const mode_t mode : {0600, 0644, 0660}) {
    ASSERT_TRUE(files_.write("map.dxf", "old"));
    ASSERT_EQ(::chmod(files_.path_of("map.dxf").c_str(), mode), 0);
    ASSERT_TRUE(files_.write("map.dxf", "new"));
    ASSERT_TRUE(files_.create("map.dxf"));
    struct stat status {};
    ASSERT_EQ(::stat(files_.path_of("map.dxf").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777U, mode);
  }
}

TEST_F(FileFolderTest, OnlyProgramsOfThisHostNameOtherFiles) {
  ASSERT_EQ(::setenv("RACK_FILES", files_.path().c_str(), 1), 0);
  ASSERT_TRUE(files_.write("map.dxf", "lines"));
  for (const bool foreign : {false, true})
    EXPECT_EQ(file_to_read("map.dxf", foreign).value(), files_.path_of("map.dxf"));
  EXPECT_EQ(file_to_read("/etc/hostname", false).value(), "/etc/hostname");
  EXPECT_EQ(file_to_read("other.dxf", false).value(), "other.dxf") << "in the working directory";
  EXPECT_FALSE(file_to_read("/etc/hostname", true));
  EXPECT_FALSE(file_to_read("other.dxf", true));
  ::unsetenv("RACK_FILES");
}

}  // namespace file_folder_test
}  // namespace rack
