#include "components/files/log_file.h"

#include <csignal>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "components/files/file_folder.h"
#include "tests/support/temporary_folder.h"

namespace rack {
namespace log_file_test {

// An empty file, which replaces an old one.
LogFile new_log(const tims::test::TemporaryFolder& folder) {
  LogFile file;
  auto made = FileFolder(folder.path()).create("a.dat");
  EXPECT_TRUE(made) << made.error().message();
  file.begin(std::move(*made), folder.path() / "a.dat");
  return file;
}

std::string content(const std::string& path) {
  return tims::os::read_file(path).value_or("unreadable");
}

TEST(LogFile, GrowsByLines) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "a.dat";
  LogFile file = new_log(folder);
  EXPECT_TRUE(file.append("one\n").ok());
  EXPECT_TRUE(file.append("two\n").ok());
  EXPECT_EQ(content(path), "one\ntwo\n");
  file = new_log(folder);
  EXPECT_EQ(content(path), "") << "the file must be empty";
}

// Incomplete lines after a loss of power, also with zeros, which file systems store in place of
// data that was not written.
TEST(LogFile, GoesOnBehindTheLastWholeLine) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "a.dat";
  for (const std::string& torn : {std::string(), std::string("tw"), std::string(9000, '\0')}) {
    std::ofstream(path) << "one\n" << torn;
    LogFile file;
    const auto cut = file.open(path);
    ASSERT_TRUE(cut.ok());
    EXPECT_EQ(*cut, torn.size());
    EXPECT_TRUE(file.append("two\n").ok());
    EXPECT_TRUE(file.sync().ok());
    EXPECT_EQ(content(path), "one\ntwo\n");
    EXPECT_EQ(file.size(), 8U);
  }
  std::ofstream(path) << "no line at all";
  EXPECT_EQ(*LogFile().open(path), 14U);
  EXPECT_EQ(*LogFile().open(folder.path() / "new"), 0U);
  EXPECT_TRUE(sync_folder(folder.path()).ok());
}

TEST(LogFile, NoPlaceForAFile) {
  LogFile file;
  const auto created = file.open("/no/such/folder/a.dat");
  ASSERT_FALSE(created.ok());
  EXPECT_EQ(created.error(), tims::Errc::kSystem);
}

TEST(LogFile, ReportsThatTheDiskIsFull) {
  LogFile file;
  ASSERT_TRUE(file.open("/dev/full").ok());
  const auto appended = file.append("one\n");
  ASSERT_FALSE(appended.ok());
  EXPECT_EQ(appended.error(), tims::Errc::kDiskFull);
  EXPECT_NE(appended.error().detail().find("/dev/full: No space left"), std::string::npos);
}

TEST(LogFile, NeverKeepsHalfALine) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "a.dat";
  LogFile file = new_log(folder);
  EXPECT_TRUE(file.append("one\n").ok());
  // A limit of the file size simulates a disk with four bytes left.
  (void)std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 8, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto appended = file.append("a longer line\n");
  ASSERT_FALSE(appended.ok());
  EXPECT_EQ(appended.error(), tims::Errc::kDiskFull);
  EXPECT_EQ(content(path), "one\n");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_TRUE(file.append("two\n").ok());
  EXPECT_EQ(content(path), "one\ntwo\n");
}

TEST(LogFile, MayBeAPipeOrADevice) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  for (const std::string& name : {path, std::string("/dev/null")}) {
    LogFile file;
    const auto opened = file.open(name);
    ASSERT_TRUE(opened) << opened.error().message();
    const tims::os::File reader(::open(name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    EXPECT_TRUE(file.append("one\n"));
    EXPECT_TRUE(file.sync());
    std::string text(10, '\0');
    const ssize_t size = ::read(reader.get(), text.data(), text.size());
    EXPECT_EQ(size, name == path ? 4 : 0);
  }
}

}  // namespace log_file_test
}  // namespace rack
