#include "os/file.h"

#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace tims::os {
namespace file_test {

void write(const std::string& path, const std::string& text) {
  const File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  EXPECT_EQ(::write(file.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

TEST(ReadFile, ReturnsAllBytes) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  for (const std::string& text :
       {std::string(), std::string("a\0b\n", 4), std::string(200'000, 'x')}) {
    write(path, text);
    const auto content = read_file(path);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(*content, text);
  }
}

TEST(ReadFile, ErrorsNameTheFileAndTheReason) {
  const auto missing = read_file("/no/such/file");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error(), Errc::kSystem);
  EXPECT_EQ(missing.error().detail(), "/no/such/file: No such file or directory");
  const auto folder = read_file("/proc");
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().detail(), "/proc: Is a directory");
}

// /dev/zero would be read until the limit, a disk for hours.
TEST(ReadFile, DevicesAreRefused) {
  for (const std::string path : {"/dev/zero", "/dev/urandom", "/dev/full"}) {
    const auto content = read_file(path);
    ASSERT_FALSE(content) << path;
    EXPECT_EQ(content.error().detail(), path + ": is a device, not a file");
  }
  EXPECT_EQ(read_file("/dev/null").value(), "") << "the usual name of an empty file";
}

TEST(ReadFile, AFileMayBeAsLargeAsTheLimit) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "a";
  write(path, std::string(1000, 'x'));
  EXPECT_TRUE(read_file(path, 1000));
  const auto content = read_file(path, 999);
  ASSERT_FALSE(content);
  EXPECT_EQ(content.error(), Errc::kTooBig);
  EXPECT_EQ(content.error().detail(), path + ": larger than 999 bytes");
  write(path, std::string((1 << 20) + 1, 'x'));
  const auto larger = read_file(path, 1 << 20);
  ASSERT_FALSE(larger);
  EXPECT_EQ(larger.error().detail(), path + ": larger than 1 MB");
}

TEST(ReadFile, ReadsWhatHasNoSize) {
  const auto comm = read_file("/proc/self/comm");
  ASSERT_TRUE(comm);
  EXPECT_TRUE(comm->ends_with('\n'));
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::thread writer([&] { write(path, "text"); });
  EXPECT_EQ(read_file(path).value_or("an error"), "text");
  writer.join();
}

}  // namespace file_test
}  // namespace tims::os
