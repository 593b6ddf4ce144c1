// A program started by a test. Its output is collected; it is killed when the test ends.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "os/process.h"
#include "tests/support/patience.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

using os::ExitStatus;

struct ChildOptions {
  std::vector<std::string> environment;  // "NAME=value", added to the test's own
  std::string folder;                    // working directory; default: the test's
};

// The system kills the child when the *thread* that started it ends (PR_SET_PDEATHSIG): start
// children from a thread that lives as long as they should.
class ChildProcess {
 public:
  // Finds the program as os::Process does. Fails if it cannot be executed.
  static Result<ChildProcess> start(std::vector<std::string> command,
                                    const ChildOptions& options = {});

  ChildProcess(ChildProcess&&) noexcept;
  ChildProcess& operator=(ChildProcess&&) noexcept;
  ~ChildProcess();  // kills it

  [[nodiscard]] pid_t pid() const;

  // The next line of stdout or stderr that contains `part`, after the one found last. Fails at
  // the deadline (kTimeout), or as soon as the output has ended (kClosed), with all output so far
  // in the error.
  Result<std::string> wait_for_line(std::string_view part, Duration limit = kPatience);

  void signal(int number);
  // The exit status, after the output has been read to its end. kTimeout: still running.
  Result<ExitStatus> wait(Duration limit = kPatience);
  // signal() and wait().
  Result<ExitStatus> stop(int number, Duration limit = kPatience);

  // Everything written so far.
  [[nodiscard]] std::string output() const;  // both streams, by lines in order of arrival
  [[nodiscard]] std::string standard_output() const;
  [[nodiscard]] std::string standard_error() const;

 private:
  struct State;
  explicit ChildProcess(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tims::test
