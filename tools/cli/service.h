// Functions for programs that supervise other programs: starting and ending processes, running in
// the background, and reporting events. Requests from another terminal: control.h.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "os/process.h"
#include "tims/time.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"

namespace timsctl {

// --- Processes (os/process.h); errors are thrown as Failure

using tims::os::Launch;
using tims::os::Process;
using tims::os::Ran;

// Runs a program to its end. Throws Failure if it cannot be executed.
Ran run(const Launch& launch, std::string_view input = {});
// The same; throws Failure with the output of the program if its exit status is not 0.
void run_or_fail(const Launch& launch, std::string_view input = {});
// Starts a program in its own process group. Throws Failure if it cannot be executed.
Process start(Launch launch);
// Replaces this process by the program. Returns only by throwing Failure.
[[noreturn]] void become(const Launch& launch);

// A program that may run, and be started again when it has ended.
class Child {
 public:
  // In its own process group. Throws Failure if it cannot be executed.
  void start(const Launch& launch) { process_ = timsctl::start(launch); }

  [[nodiscard]] bool runs() const { return process_.has_value(); }
  [[nodiscard]] std::optional<pid_t> pid() const;
  [[nodiscard]] int descriptor() const;  // readable when it has ended; -1: it does not run
  void signal(int number) const;         // to its process group
  // Returns each end once. Waits for it until `within` is over.
  std::optional<tims::os::ExitStatus> take_end(tims::Duration within = {});

 private:
  std::optional<Process> process_;
};

// Sends the signal to all, and SIGKILL to those that still run after `patience`; returns when none
// runs. `look_after` waits until the deadline at most, and takes the ends.
void end_all(std::span<const Child* const> children, int signal, tims::Duration patience,
             const std::function<void(tims::Time deadline)>& look_after);

// --- Running in the background

using Work = std::function<Exit(const std::function<void()>& ready)>;

// Runs `work`. With --detach in a child process: this function returns when the work has called
// `ready` (kDone) or has ended (its exit status), and from `ready` on its output goes to the file
// `log`. Otherwise `ready` shows the note `is_up`, and how the work ends. Throws Failure if the
// system cannot create a process. Must be called before any thread is started.
Exit run_service(const Context& context, const std::string& log, std::string_view is_up,
                 const Work& work);

// --- Events of the supervised programs: time, subject and text, as one line or one JSON object
// each

// The lines are written as far as stdout takes them without waiting: a reader that has stopped must
// not stop the supervision. Lines that find no room are counted.
class EventLines {
 public:
  EventLines(Context& context, std::string_view schema, int subject_width);
  // Waits a moment for a slow reader.
  ~EventLines();
  EventLines(const EventLines&) = delete;
  EventLines& operator=(const EventLines&) = delete;

  // Sets the zero of the event times.
  void begin();
  [[nodiscard]] tims::Time began() const { return began_; }

  // Throws Interrupted if the reader has closed stdout.
  void write_line(std::string_view event, std::string_view subject, std::string_view text);
  // Writes lines that are waiting. Call it at flush_at(); kNever: none are waiting.
  void flush();
  [[nodiscard]] tims::Time flush_at() const;

 private:
  [[nodiscard]] std::string line_of(std::string_view event, std::string_view subject,
                                    std::string_view text) const;

  Context& context_;
  std::string_view schema_;
  int subject_width_;
  tims::Time began_;
  std::string waiting_;  // whole lines, the first perhaps without its beginning
  std::uint64_t dropped_ = 0;
};

// If stdout is the log of a service in the background and longer than this: renames it to "LOG.1"
// and begins a new one.
inline constexpr std::size_t kLogMax = 8 << 20;
void keep_log_short(const std::string& log, std::size_t bytes_max = kLogMax);

}  // namespace timsctl
