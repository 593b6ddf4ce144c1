// Functions for programs that supervise other programs: starting processes, running in the
// background, reporting events, and answering requests from another terminal.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "os/file.h"
#include "os/process.h"
#include "tims/time.h"
#include "tools/cli/connection.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

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

// --- Requests from another terminal: one JSON record as request, one as answer. A supervisor is
// running if and only if it listens at its socket.

bool somebody_listens(const std::string& path);
// Sends a request. Throws Failure: no answer in time, or the failure that the server reported.
// `nobody` is thrown if no process listens.
json::object ask_control(const std::string& path, const json::object& question,
                         const Signals& signals, tims::Duration timeout, const Failure& nobody);

// The server of these requests. It handles {"do": "down"} itself: that request is answered at the
// end, by end().
class ControlServer {
 public:
  explicit ControlServer(tims::os::File listener) : listener_(std::move(listener)) {}

  // Waits for a request, until one of `others` is readable, or the deadline. Throws Interrupted.
  void wait(std::vector<int> others, const Signals& signals, tims::Time deadline) const;
  // Handles a waiting request, if there is one. A Failure thrown by `answer` is sent as the answer.
  void take_question(const Signals& signals,
                     const std::function<json::object(const json::object& question)>& answer);
  [[nodiscard]] bool asked_to_end() const { return static_cast<bool>(ending_); }
  // Closes the socket and answers the request to end.
  void end(const json::object& answer);

 private:
  tims::os::File listener_;
  tims::os::File ending_;  // connection of the request to end
};

// Empty if the text is not a JSON object.
json::object parse_object(std::string_view text);

// --- Running in the background

// Runs `work` in a child process and returns when that has called `ready` (kDone) or has ended (its
// exit status). After `ready`, its output goes to the file `log`. Throws Failure if the system
// cannot create a process. Must be called before any thread is started.
Exit run_detached(const std::string& log,
                  const std::function<Exit(const std::function<void()>& ready)>& work);

// --- Events of the supervised programs: time, subject and text, as one line or one JSON object
// each

class EventLines {
 public:
  EventLines(Context& context, std::string_view schema, int subject_width);

  // Sets the zero of the event times.
  void begin();
  [[nodiscard]] tims::Time began() const { return began_; }

  void say(std::string_view event, std::string_view subject, std::string_view text) const;

 private:
  Context& context_;
  std::string_view schema_;
  int subject_width_;
  tims::Time began_;
};

}  // namespace timsctl
