#include "tests/support/child_process.h"

#include <array>
#include <csignal>
#include <set>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/wakeup.h"

namespace tims::test {
namespace child_process_test {

Result<ChildProcess> shell(const char* script, const ChildOptions& options = {}) {
  return ChildProcess::start({"sh", "-c", script}, options);
}

TEST(ChildProcess, CollectsBothOutputsAndTheExitStatus) {
  auto child = shell("echo one; echo two >&2; printf three; exit 7");
  ASSERT_TRUE(child) << child.error().message();
  const auto status = child->wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(*status, ExitStatus{.code = 7});
  EXPECT_EQ(status->to_string(), "exit status 7");
  EXPECT_FALSE(status->success());
  EXPECT_EQ(child->standard_output(), "one\nthree\n");
  EXPECT_EQ(child->standard_error(), "two\n");
}

TEST(ChildProcess, WaitsForLinesOneAfterTheOther) {
  auto child = shell("echo listening 1; echo other; echo listening 2 >&2; exec cat /dev/zero");
  ASSERT_TRUE(child);
  std::set<std::string> lines;
  for (int i = 0; i < 2; ++i) {
    const auto line = child->wait_for_line("listening");
    ASSERT_TRUE(line) << line.error().message();
    lines.insert(*line);
  }
  EXPECT_EQ(lines, (std::set<std::string>{"listening 1", "listening 2"}));
}

TEST(ChildProcess, EndOfOutputEndsTheWait) {
  auto child = shell("echo cannot open socket >&2; exit 1");
  ASSERT_TRUE(child);
  const auto line = child->wait_for_line("listening");
  ASSERT_FALSE(line);
  EXPECT_TRUE(line.error() == Errc::kClosed);
  EXPECT_NE(line.error().message().find("cannot open socket"), std::string::npos)
      << "the error contains the output of the program";
}

TEST(ChildProcess, DeadlinesPass) {
  auto child = shell("echo ready; exec sleep 1000");
  ASSERT_TRUE(child);
  ASSERT_TRUE(child->wait_for_line("ready"));
  EXPECT_TRUE(child->wait_for_line("more", std::chrono::milliseconds(1)).error() == Errc::kTimeout);
  EXPECT_TRUE(child->wait(std::chrono::milliseconds(1)).error() == Errc::kTimeout);
  const auto status = child->stop(SIGTERM);
  ASSERT_TRUE(status);
  EXPECT_EQ(*status, ExitStatus{.signal = SIGTERM});
}

TEST(ChildProcess, GetsEnvironmentAndFolder) {
  auto child = shell("echo $COLOUR; pwd", {.environment = {"COLOUR=green"}, .folder = "/usr"});
  ASSERT_TRUE(child);
  ASSERT_TRUE(child->wait());
  EXPECT_EQ(child->output(), "green\n/usr\n");
}

TEST(ChildProcess, ProgramThatDoesNotExist) {
  const auto child = ChildProcess::start({"/no/such/program"});
  ASSERT_FALSE(child);
  EXPECT_NE(child.error().message().find("/no/such/program"), std::string::npos);
}

TEST(ChildProcess, IsKilledWithItsObject) {
  pid_t pid = 0;
  {
    auto child = shell("exec sleep 1000");
    ASSERT_TRUE(child);
    pid = child->pid();
    EXPECT_EQ(::kill(pid, 0), 0);
  }
  EXPECT_EQ(::kill(pid, 0), -1);
}

// A crashing test must not leave a router that keeps its ports. The test and its child both hold
// the pipe open, so it ends when both have exited.
TEST(ChildProcess, IsKilledWhenTheTestCrashes) {
  std::array<int, 2> fds{};
  ASSERT_EQ(::pipe(fds.data()), 0);
  os::File read_end(fds[0]);
  os::File write_end(fds[1]);
  const pid_t dying_test = ::fork();
  if (dying_test == 0) {
    auto child = shell("echo up; exec sleep 1000");
    const bool up = child && child->wait_for_line("up");
    ::_exit(up ? 0 : 1);  // no destructor
  }
  write_end.reset();
  int status = -1;
  ASSERT_EQ(::waitpid(dying_test, &status, 0), dying_test);
  ASSERT_EQ(status, 0) << "the child did not start";
  EXPECT_TRUE(os::is_ready(read_end.get(), POLLIN, os::deadline_after(kPatience)));
}

}  // namespace child_process_test
}  // namespace tims::test
