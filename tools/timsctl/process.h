// Other programs: run to their end, or started in a network namespace and watched.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "os/wakeup.h"
#include "tools/timsctl/split_command.h"

namespace timsctl {

struct Launch {
  CommandLine command;                     // command[0]: in timsctl's own folder, else in PATH
  std::string network{};                   // name of the namespace to run in; empty: this one
  std::vector<std::string> environment{};  // "NAME=value", over timsctl's own
  std::string folder{};                    // to run in; empty: this process's
  std::string log{};  // file for stdout and stderr, appended to; empty: they stay as they are
  // Descriptors for stdin (else /dev/null) and for stdout and stderr (else `log`).
  int in = -1;
  int out = -1;
};

struct Ran {
  int code = 0;        // 128 and the signal's number when it was killed
  std::string output;  // stdout and stderr
};
// To its end. Throws Failure when it cannot be executed.
Ran run(const Launch& launch, std::string_view input = {});
// The same; throws Failure with the program's words when it ended with another status than 0.
void run_or_fail(const Launch& launch, std::string_view input = {});

// A program that goes on running. The system kills it when this process ends, however that happens.
class Child {
 public:
  static Child start(const Launch& launch);  // throws Failure when it cannot be executed

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] int descriptor() const { return pidfd_.get(); }  // readable when it has ended
  [[nodiscard]] bool has_ended(tims::Duration within = {}) const {
    return tims::os::is_readable(pidfd_.get(), within);
  }
  // Of the program and what it has started.
  void signal(int number) const;
  // Its exit status as in Ran, after it has ended.
  [[nodiscard]] int reap() const;

 private:
  Child(pid_t pid, tims::os::File pidfd) : pid_(pid), pidfd_(std::move(pidfd)) {}
  pid_t pid_;
  tims::os::File pidfd_;
};

std::string end_text(int status);  // "exit status 1", "killed by signal 9"

// This process becomes that program. Comes back only by throwing Failure.
[[noreturn]] void become(const Launch& launch);

std::string namespace_path(std::string_view network);
// Every process in the namespace, this one not.
std::vector<pid_t> processes_in(std::string_view network);

}  // namespace timsctl
