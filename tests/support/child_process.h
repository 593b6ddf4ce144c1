// A program started by a test: its output is collected as it comes, and it never outlives the test.
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
  std::string folder;                    // to run in; default: the test's
};

// The system kills the child when the *thread* that started it ends (PR_SET_PDEATHSIG): start
// children from a thread that lives as long as they should.
class ChildProcess {
 public:
  // As os::Process finds it. Fails when the program cannot be executed.
  static Result<ChildProcess> start(std::vector<std::string> command,
                                    const ChildOptions& options = {});

  ChildProcess(ChildProcess&&) noexcept;
  ChildProcess& operator=(ChildProcess&&) noexcept;
  ~ChildProcess();  // kills it

  [[nodiscard]] pid_t pid() const;

  // The next line of stdout or stderr that contains `part`, behind the one found last. Fails at
  // the deadline (kTimeout), or as soon as the output has ended (kClosed), with all output so far
  // in the error.
  Result<std::string> wait_for_line(std::string_view part, Duration limit = kPatience);

  void signal(int number);
  // Its exit status, once its output has been read to the end. kTimeout: it still runs.
  Result<ExitStatus> wait(Duration limit = kPatience);
  // signal() and wait().
  Result<ExitStatus> stop(int number, Duration limit = kPatience);

  // Everything written so far.
  [[nodiscard]] std::string output() const;  // both, line by line as they came
  [[nodiscard]] std::string standard_output() const;
  [[nodiscard]] std::string standard_error() const;

 private:
  struct State;
  explicit ChildProcess(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tims::test
