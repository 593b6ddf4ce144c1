// What a program needs that keeps other programs running: it starts them, goes on in the
// background, says what happens to them, and answers those who ask it from another terminal.
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

// --- Other programs (os/process.h), with failures thrown

using tims::os::Launch;
using tims::os::Process;
using tims::os::Ran;

// To its end. Throws Failure when it cannot be executed.
Ran run(const Launch& launch, std::string_view input = {});
// The same; throws Failure with the program's words when it ended with another status than 0.
void run_or_fail(const Launch& launch, std::string_view input = {});
// In a group of its own. Throws Failure when it cannot be executed.
Process start(Launch launch);
// This process becomes that program. Comes back only by throwing Failure.
[[noreturn]] void become(const Launch& launch);

// --- Questions from another terminal: one record of JSON there, one back. Who listens is there;
// nothing else tells.

bool somebody_listens(const std::string& path);
// Throws Failure: no answer in time, or what the other one threw. `nobody`: thrown when nobody
// listens.
json::object ask_control(const std::string& path, const json::object& question,
                         const Signals& signals, tims::Duration timeout, const Failure& nobody);

// Answers them. {"do": "down"} is for itself: who asks that is told when all has ended.
class ControlServer {
 public:
  explicit ControlServer(tims::os::File listener) : listener_(std::move(listener)) {}

  // Until somebody asks, one of the others can be read, or the deadline. Throws Interrupted.
  void wait(std::vector<int> others, const Signals& signals, tims::Time deadline) const;
  // Takes the question that waits, if one does. What `answer` throws as Failure is answered.
  void take_question(const Signals& signals,
                     const std::function<json::object(const json::object& question)>& answer);
  [[nodiscard]] bool asked_to_end() const { return static_cast<bool>(ending_); }
  // All has ended: nobody listens any more.
  void end(const json::object& answer);

 private:
  tims::os::File listener_;
  tims::os::File ending_;  // who asked for the end
};

// Empty when the text is no JSON object.
json::object parse_object(std::string_view text);

// --- Going on in the background

// Runs `work` in a process of its own, and returns when that has called `ready` (kDone) or has
// ended (its exit status). From `ready` on, what it says goes to the file `log`. Throws Failure
// when the system has no room for a process. Before any thread is started.
Exit run_detached(const std::string& log,
                  const std::function<Exit(const std::function<void()>& ready)>& work);

// --- What happens to the programs: when, to whom and what, a line each, or an object of JSON

class EventLines {
 public:
  EventLines(Context& context, std::string_view schema, int subject_width);

  // Times count from now on.
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
