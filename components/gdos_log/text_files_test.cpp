#include "components/gdos_log/text_files.h"

#include <csignal>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "proxies/gdos_texts.h"
#include "tests/support/temporary_folder.h"

namespace rack::gdos_log {

namespace text_files_test {

namespace fs = std::filesystem;

std::string all_of(const fs::path& folder) {
  std::string text;
  for (const fs::path& path : gdos::log_paths(folder))
    text += tims::os::read_file(path).value_or("unreadable") + "|";
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

TEST_F(TextFilesTest, NewestLinesOfSeveralFiles) {
  EXPECT_EQ(newest_lines(folder_, 100), "") << "there is no folder";
  open({.bytes = 6, .files = 3});
  for (const char* line : {"11\n", "22\n", "33\n", "44\n", "55\n"}) append(line);
  ASSERT_EQ(all_of(folder_), "11\n22\n|33\n44\n|55\n|");
  EXPECT_EQ(newest_lines(folder_, 100), "11\n22\n33\n44\n55\n");
  EXPECT_EQ(newest_lines(folder_, 15), "11\n22\n33\n44\n55\n");
  EXPECT_EQ(newest_lines(folder_, 14), "22\n33\n44\n55\n") << "no part of a line";
  EXPECT_EQ(newest_lines(folder_, 4), "55\n");
  EXPECT_EQ(newest_lines(folder_, 2), "");
  std::ofstream(folder_ / gdos::kCurrentFile, std::ios::app) << "6";
  EXPECT_EQ(newest_lines(folder_, 100), "11\n22\n33\n44\n55\n") << "it is being written";
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

TEST_F(TextFilesTest, ARemovedFileIsCreatedAgain) {
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

using namespace std::chrono_literals;

constexpr tims::Address kChassis(0x00110000);
constexpr tims::Address kLadar(0x00140000);
constexpr tims::Time kStart(1000s);

std::uint32_t passed(SenderLimits& limits, tims::Time now, tims::Address sender, gdos::Level level,
                     int texts = 1000) {
  std::uint32_t count = 0;
  for (int i = 0; i < texts; ++i) count += limits.take(now, sender, level) ? 1 : 0;
  return count;
}

TEST(SenderLimits, DetailsTakeNoRoomOfErrorsNorOfOthers) {
  SenderLimits limits;
  EXPECT_EQ(passed(limits, kStart, kChassis, gdos::Level::kDetail), SenderLimits::kOtherBurst);
  EXPECT_FALSE(limits.take(kStart, kChassis, gdos::Level::kInfo));
  EXPECT_EQ(passed(limits, kStart, kChassis, gdos::Level::kError), SenderLimits::kUrgentBurst);
  EXPECT_TRUE(limits.take(kStart, kLadar, gdos::Level::kDetail));
  EXPECT_GT(SenderLimits::kUrgentBurst, SenderLimits::kOtherBurst);
}

TEST(SenderLimits, ReportsTheNumberOnceASecond) {
  SenderLimits limits;
  (void)passed(limits, kStart, kChassis, gdos::Level::kDetail, 150);
  EXPECT_TRUE(limits.take_suppressed(kStart + 900ms).empty());
  const auto suppressed = limits.take_suppressed(kStart + 1s);
  ASSERT_EQ(suppressed.size(), 1U);
  EXPECT_EQ(suppressed[0].sender, kChassis);
  EXPECT_EQ(suppressed[0].count, 50U);
  EXPECT_TRUE(limits.take_suppressed(kStart + 1h).empty());
}

TEST(SenderLimits, IsBounded) {
  SenderLimits limits;
  // All senders have sent a text, and none is removed yet.
  for (std::uint32_t i = 1; i <= SenderLimits::kSendersMax; ++i)
    EXPECT_TRUE(limits.take(kStart, tims::Address(i), gdos::Level::kPrint));
  std::uint32_t of_newcomers = 0;
  for (std::uint32_t i = 0; i < 1000; ++i)
    of_newcomers += limits.take(kStart, tims::Address(i + 5000), gdos::Level::kDetail) ? 1 : 0;
  EXPECT_EQ(of_newcomers, SenderLimits::kOtherBurst) << "they share one limit";
  EXPECT_EQ(passed(limits, kStart + 1h, tims::Address(9999), gdos::Level::kDetail),
            SenderLimits::kOtherBurst)
      << "inactive senders are removed";
}

}  // namespace text_files_test

}  // namespace rack::gdos_log
