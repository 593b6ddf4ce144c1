#include "tools/cli/service.h"

#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "os/file.h"
#include "tests/support/temporary_folder.h"

namespace timsctl {
namespace service_test {

namespace fs = std::filesystem;

// stdout and stderr of this program, given back at the end.
class Redirected {
 public:
  Redirected() : out_(::dup(STDOUT_FILENO)), err_(::dup(STDERR_FILENO)) {}
  ~Redirected() {
    ::dup2(out_.get(), STDOUT_FILENO);
    ::dup2(err_.get(), STDERR_FILENO);
  }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

  static void to(const std::string& path) {
    const tims::os::File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600));
    ::dup2(file.get(), STDOUT_FILENO);
  }

 private:
  tims::os::File out_;
  tims::os::File err_;
};

TEST(KeepLogShort, ALongOneIsRenamedAndANewOneBegins) {
  constexpr std::size_t kMost = 100;
  const tims::test::TemporaryFolder folder;
  const std::string log = folder.path() / "log";
  std::ofstream(log) << std::string(kMost, 'x');
  bool is_renamed_at_limit = false;
  bool is_renamed_above = false;
  {
    const Redirected restored;
    Redirected::to(log);
    keep_log_short(log, kMost);
    is_renamed_at_limit = fs::exists(log + ".1");
    EXPECT_EQ(::write(STDOUT_FILENO, "y", 1), 1);
    keep_log_short(log, kMost);
    is_renamed_above = fs::exists(log + ".1");
    EXPECT_EQ(::write(STDOUT_FILENO, "z", 1), 1);
  }
  EXPECT_FALSE(is_renamed_at_limit);
  EXPECT_TRUE(is_renamed_above);
  EXPECT_EQ(fs::file_size(log + ".1"), kMost + 1);
  EXPECT_EQ(fs::file_size(log), 1U);
}

TEST(KeepLogShort, OtherOutputIsLeftAlone) {
  const tims::test::TemporaryFolder folder;
  const std::string log = folder.path() / "log";
  const std::string other = folder.path() / "other";
  std::ofstream(log) << "xx";
  std::ofstream(other) << "xx";
  {
    const Redirected restored;
    Redirected::to(other);
    keep_log_short(log, 1);
    keep_log_short(folder.path() / "nowhere", 1);
  }
  EXPECT_FALSE(fs::exists(log + ".1"));
  EXPECT_EQ(fs::file_size(other), 2U);
}

}  // namespace service_test
}  // namespace timsctl
