// Other programs: started and watched, run to completion, or replacing this process. Used by the
// supervisor, the simulator and the tests; not part of the installed libtims.
//
// A started program ends together with the thread that started it (PR_SET_PDEATHSIG): start
// programs from a thread that exists as long as they should run. All memory is allocated before the
// fork, so that programs with several threads may start others.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "os/file.h"
#include "os/wakeup.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::os {

using Command = std::vector<std::string>;

struct Launch {
  Command command;        // command[0]: beside this program or installed with it, else in PATH
  std::string network{};  // namespace to run in; empty: this one
  std::vector<std::string> environment{};  // "NAME=value", added to this program's own environment
  std::string folder{};                    // working directory; empty: that of this program
  std::string log{};  // file for stdout and stderr, opened for appending; empty: unchanged
  // Descriptors for stdin (else /dev/null) and for stdout and stderr (else `log`).
  int in = -1;
  int out = -1;
  int err = -1;            // -1: same as stdout
  int inherited = -1;      // a descriptor that the program keeps, under the same number
  bool own_group = false;  // own process group, which Ctrl-C of our terminal does not reach
};

struct ExitStatus {
  int code = 0;    // valid when signal is 0
  int signal = 0;  // the signal that ended the program

  [[nodiscard]] bool success() const { return code == 0 && signal == 0; }
  // Exit status as in a shell: 128 plus the signal number.
  [[nodiscard]] int as_shell() const { return signal != 0 ? 128 + signal : code; }
  [[nodiscard]] std::string to_string() const;  // "exit status 1", "killed by signal 9"
  bool operator==(const ExitStatus&) const = default;
};

// A running program. The owner of this object may signal it and must collect its exit status.
class Process {
 public:
  // kInvalidArgument: the program cannot be executed; errno states why.
  static Result<Process> start(const Launch& launch);

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] int descriptor() const { return pidfd_.get(); }  // readable when it has ended
  [[nodiscard]] bool has_ended(Duration within = {}) const {
    return is_readable(pidfd_.get(), within);
  }
  void signal(int number) const;
  // Signals the whole process group, including the program's children; requires a group of its own.
  void signal_group(int number) const;
  // Call once, after the program has ended.
  [[nodiscard]] ExitStatus reap() const;

 private:
  Process(pid_t pid, File pidfd) : pid_(pid), pidfd_(std::move(pidfd)) {}
  pid_t pid_;
  File pidfd_;
};

struct Ran {
  ExitStatus status;
  std::string output;  // stdout and stderr
};
// Runs a program to completion with `input` on its stdin. Errors as those of Process::start().
Result<Ran> run_to_end(const Launch& launch, std::string_view input = {});

// Replaces this process by the program, with the same stdin, stdout and stderr. Returns only on
// failure.
Error become(const Launch& launch);

std::string namespace_path(std::string_view network);
// Every process in the network namespace, except this one.
std::vector<pid_t> processes_in(std::string_view network);

}  // namespace tims::os
