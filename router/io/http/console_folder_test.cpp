#include "router/io/http/console_folder.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "os/file.h"
#include "tests/support/temporary_folder.h"

namespace tims::io {
namespace console_folder_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ConsoleFolderTest : public testing::Test {
 protected:
  void SetUp() override { write("index.html", "<p>page"); }
  void write(const std::string& path, const std::string& text) {
    fs::create_directories((root() / path).parent_path());
    std::ofstream(root() / path, std::ios::binary) << text;
  }
  [[nodiscard]] fs::path root() const { return folder_.path() / "console"; }
  [[nodiscard]] std::string problem() const {
    const auto files = read_console(root());
    return files ? "none" : files.error().detail();
  }

  test::TemporaryFolder folder_;
};

TEST_F(ConsoleFolderTest, AllFilesAreRead) {
  write("main-A1B2C3D4.js", "script");
  write("main-A1B2C3D4.js.br", std::string("\0\xff", 2));
  write("icons/robot.svg", "<svg/>");
  const auto files = read_console(root());
  ASSERT_TRUE(files.ok()) << files.error().detail();
  EXPECT_EQ(files->size(), 3U);
  const HttpRequest request{
      .method = "GET", .target = "/main-A1B2C3D4.js", .fields = {{"Accept-Encoding", "br"}}};
  EXPECT_EQ(files->answer(request).stored, std::string_view("\0\xff", 2));
  EXPECT_TRUE(files->has("/icons/robot.svg"));
  // They are in memory.
  fs::remove_all(root());
  EXPECT_EQ(files->answer({.method = "GET", .target = "/"}).stored, "<p>page");
}

TEST_F(ConsoleFolderTest, TheFolderItselfMayBeALink) {
  fs::create_directory_symlink(root(), folder_.path() / "link");
  EXPECT_TRUE(read_console(folder_.path() / "link").ok());
}

TEST_F(ConsoleFolderTest, LinksAreRefused) {
  std::ofstream(folder_.path() / "secret") << "secret";
  fs::create_symlink(folder_.path() / "secret", root() / "a.txt");
  EXPECT_EQ(problem(), (root() / "a.txt").string() + ": it is a link: copy the file instead");
  fs::remove(root() / "a.txt");
  fs::create_directory_symlink("/etc", root() / "etc");
  EXPECT_THAT(problem(), HasSubstr("etc: it is a link"));
  fs::remove(root() / "etc");
  fs::create_symlink("index.html", root() / "start.html");  // also one that leads nowhere else
  EXPECT_THAT(problem(), HasSubstr("start.html: it is a link"));
}

// Opening a pipe would wait for a writer, opening a device could do anything.
TEST_F(ConsoleFolderTest, WhatIsNotAFileIsRefused) {
  ASSERT_EQ(::mkfifo((root() / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(problem(), HasSubstr("pipe: it is neither a file nor a folder"));
  fs::remove(root() / "pipe");
  const os::File socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un where{.sun_family = AF_UNIX, .sun_path = {}};
  (root() / "socket").string().copy(where.sun_path, sizeof where.sun_path - 1);
  ASSERT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&where), sizeof where), 0);
  EXPECT_THAT(problem(), HasSubstr("socket: it is neither a file nor a folder"));
}

TEST_F(ConsoleFolderTest, BoundsOfTheFolder) {
  write("a/b/c/d.txt", "");
  EXPECT_EQ(problem(), "none");
  write("a/b/c/d/e.txt", "");
  EXPECT_THAT(problem(), HasSubstr("nested too deeply"));
  fs::remove_all(root() / "a");
  for (int i = 0; i < 255; ++i) fs::create_directory(root() / ("d" + std::to_string(i)));
  EXPECT_EQ(problem(), "none");
  fs::create_directory(root() / "one-more");
  EXPECT_THAT(problem(), HasSubstr("too many files"));
}

// A sparse file of a terabyte is read up to the bound.
TEST_F(ConsoleFolderTest, BoundsOfAFile) {
  write("big.bin", std::string(ConsoleFiles::kBytesMax - 7, 'x'));
  EXPECT_EQ(problem(), "none");
  fs::resize_file(root() / "big.bin", ConsoleFiles::kBytesMax - 6);
  EXPECT_THAT(problem(), HasSubstr(": with it, the files have more than 4194304 bytes"));
  fs::resize_file(root() / "big.bin", std::uintmax_t{1} << 40);
  EXPECT_THAT(problem(), HasSubstr(": with it, the files have more than 4194304 bytes"));
}

TEST_F(ConsoleFolderTest, ProblemsNameTheFolder) {
  EXPECT_EQ(read_console("/no/such").error().detail(), "/no/such: No such file or directory");
  EXPECT_THAT(read_console(root() / "index.html").error().detail(), HasSubstr("Not a directory"));
  fs::remove(root() / "index.html");
  EXPECT_EQ(problem(), root().string() + ": there is no index.html in it");
}

}  // namespace console_folder_test
}  // namespace tims::io
