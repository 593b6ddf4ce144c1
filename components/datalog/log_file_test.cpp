#include "components/datalog/log_file.h"

#include <csignal>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/support/temporary_folder.h"

namespace rack::datalog {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(LogFile, GrowsByLines) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "a.dat";
  LogFile file;
  ASSERT_TRUE(file.create(path).ok());
  EXPECT_TRUE(file.append("one\n").ok());
  EXPECT_TRUE(file.append("two\n").ok());
  EXPECT_EQ(content(path), "one\ntwo\n");
  ASSERT_TRUE(file.create(path).ok());
  EXPECT_EQ(content(path), "") << "anew";
}

TEST(LogFile, NoPlaceForAFile) {
  LogFile file;
  EXPECT_FALSE(file.create("/no/such/folder/a.dat").ok());
}

TEST(LogFile, SaysThatTheDiskIsFull) {
  LogFile file;
  ASSERT_TRUE(file.create("/dev/full").ok());
  const auto appended = file.append("one\n");
  ASSERT_FALSE(appended.ok());
  EXPECT_NE(appended.error().detail().find("/dev/full: No space left"), std::string::npos);
}

TEST(LogFile, NeverKeepsHalfALine) {
  const tims::test::TemporaryFolder folder;
  const std::string path = folder.path() / "a.dat";
  LogFile file;
  ASSERT_TRUE(file.create(path).ok());
  EXPECT_TRUE(file.append("one\n").ok());
  // Files may be no larger than this now: as a disk with four bytes left.
  (void)std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 8, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_FALSE(file.append("a longer line\n").ok());
  EXPECT_EQ(content(path), "one\n");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_TRUE(file.append("two\n").ok());
  EXPECT_EQ(content(path), "one\ntwo\n");
}

}  // namespace
}  // namespace rack::datalog
