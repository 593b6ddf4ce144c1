#include "components/gdos_log/text_files.h"

#include <csignal>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "proxies/gdos_texts.h"
#include "tests/support/temporary_folder.h"

namespace rack::gdos_log {

namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}
std::string all_of(const fs::path& folder) {
  std::string text;
  for (const fs::path& path : gdos::log_paths(folder)) text += content(path) + "|";
  return text;
}

class TextFilesTest : public testing::Test {
 protected:
  void open(const TextFileLimits& limits) {
    const auto opened = files_.open(folder_, limits);
    ASSERT_TRUE(opened) << opened.error().message();
  }
  void append(std::string_view line) {
    const auto good = files_.append(line);
    EXPECT_TRUE(good) << good.error().message();
  }

  const tims::test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "a" / "log";
  TextFiles files_;
};

TEST_F(TextFilesTest, AFewFilesOfAFewLines) {
  open({.bytes = 4, .files = 3});
  for (const char* line : {"1\n", "2\n", "3\n", "4\n", "5\n"}) append(line);
  EXPECT_EQ(all_of(folder_), "1\n2\n|3\n4\n|5\n|");
  append("6\n");
  append("7\n");
  EXPECT_EQ(all_of(folder_), "3\n4\n|5\n6\n|7\n|");
  append("a line larger than a file\n");
  EXPECT_EQ(all_of(folder_), "5\n6\n|7\n|a line larger than a file\n|");
  EXPECT_TRUE(fs::exists(folder_ / gdos::numbered_file(4))) << "numbers go on";
}

TEST_F(TextFilesTest, OneFileOnly) {
  open({.bytes = 4, .files = 1});
  for (const char* line : {"1\n", "2\n", "3\n"}) append(line);
  EXPECT_EQ(all_of(folder_), "3\n|");
}

TEST_F(TextFilesTest, GoesOnWhereItEnded) {
  open({});
  append("1\n");
  files_.close();
  std::ofstream(folder_ / gdos::kCurrentFile, std::ios::app) << "hal";
  const auto opened = files_.open(folder_, {});
  ASSERT_TRUE(opened);
  EXPECT_EQ(*opened, 3U) << "half a line was cut off";
  append("2\n");
  EXPECT_EQ(all_of(folder_), "1\n2\n|");
}

TEST_F(TextFilesTest, OldFilesGo) {
  open({.bytes = 2});
  append("1\n");
  append("2\n");
  append("3\n");
  files_.close();
  const auto ago = [](int days) {
    return fs::file_time_type::clock::now() - std::chrono::days(days);
  };
  fs::last_write_time(folder_ / gdos::numbered_file(1), ago(8));
  fs::last_write_time(folder_ / gdos::numbered_file(2), ago(6));
  open({.age = std::chrono::days(7)});
  EXPECT_EQ(all_of(folder_), "2\n|3\n|");
}

TEST_F(TextFilesTest, AFileThatWasTakenAwayIsBegunAnew) {
  open({});
  append("1\n");
  fs::remove_all(folder_);
  fs::create_directories(folder_);
  EXPECT_TRUE(files_.sync());
  append("2\n");
  EXPECT_EQ(all_of(folder_), "2\n|");
}

TEST_F(TextFilesTest, OneWriterAFolder) {
  open({});
  TextFiles second;
  const auto opened = second.open(folder_, {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error(), tims::Errc::kAddressInUse);
  files_.close();
  EXPECT_TRUE(second.open(folder_, {}));
}

TEST_F(TextFilesTest, NoPlaceForAFolder) {
  const auto opened = files_.open("/proc/nowhere", {});
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().detail().find("/proc/nowhere"), std::string::npos);
}

TEST_F(TextFilesTest, AFullDiskKeepsWholeLines) {
  open({});
  append("1\n");
  (void)std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 4, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto appended = files_.append("a longer one\n");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(appended);
  EXPECT_EQ(appended.error(), tims::Errc::kDiskFull);
  append("2\n");
  EXPECT_EQ(all_of(folder_), "1\n2\n|");
}

}  // namespace

}  // namespace rack::gdos_log
