// Other programs: started and watched, run to their end, or become. For the supervisor, the
// simulator and the tests; not part of the installed libtims.
//
// A program that is started ends with the thread that started it, however that ends
// (PR_SET_PDEATHSIG): start programs from a thread that lives as long as they should. All memory is
// prepared before the fork, so that programs with several threads may start others.
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
  std::vector<std::string> environment{};  // "NAME=value", over this program's own
  std::string folder{};                    // to run in; empty: this program's
  std::string log{};  // file for stdout and stderr, appended to; empty: they stay as they are
  // Descriptors for stdin (else /dev/null) and for stdout and stderr (else `log`).
  int in = -1;
  int out = -1;
  int err = -1;            // -1: as stdout
  bool own_group = false;  // not reached by the Ctrl-C of our terminal
};

struct ExitStatus {
  int code = 0;    // valid when signal is 0
  int signal = 0;  // that ended it

  [[nodiscard]] bool success() const { return code == 0 && signal == 0; }
  // As shells have it: 128 and the signal's number.
  [[nodiscard]] int as_shell() const { return signal != 0 ? 128 + signal : code; }
  [[nodiscard]] std::string to_string() const;  // "exit status 1", "killed by signal 9"
  bool operator==(const ExitStatus&) const = default;
};

// A program that runs. Who ends it, and takes its exit status, is whoever has this.
class Process {
 public:
  // kInvalidArgument: it cannot be executed; errno says why.
  static Result<Process> start(const Launch& launch);

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] int descriptor() const { return pidfd_.get(); }  // readable when it has ended
  [[nodiscard]] bool has_ended(Duration within = {}) const {
    return is_readable(pidfd_.get(), within);
  }
  void signal(int number) const;
  // To what it has started, too; it has a group of its own.
  void signal_group(int number) const;
  // After it has ended, once.
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
// To its end, with this on stdin. Errors as those of Process::start().
Result<Ran> run_to_end(const Launch& launch, std::string_view input = {});

// This process becomes that program, with its own stdin, stdout and stderr. Returns only why not.
Error become(const Launch& launch);

std::string namespace_path(std::string_view network);
// Every process in the namespace, this one not.
std::vector<pid_t> processes_in(std::string_view network);

}  // namespace tims::os
