// What supervisors run on this host, and requests to them from another terminal: one JSON record as
// request, one as answer. Each has a folder of its name; it is running if and only if a process
// listens at the socket there.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "os/file.h"
#include "tims/time.h"
#include "tools/cli/connection.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace timsctl {

// How long a supervisor may take to stop, or to start and stop programs.
inline constexpr tims::Duration kServiceAnswers = std::chrono::seconds(30);

// Everything of one kind that runs on this host. A key is a name, or a name with "@" and more if
// several of that name may run.
class Services {
 public:
  struct Hints {
    std::string_view none;         // when nothing runs
    std::string_view not_running;  // when what was asked does not run
    std::string_view several;      // when a name is needed
  };
  // `what`: "robot". `folder`: contains the folder of each.
  Services(std::string_view what, std::string folder, const Hints& hints)
      : what_(what), folder_(std::move(folder)), hints_(hints) {}

  [[nodiscard]] std::string folder_of(std::string_view key) const;
  [[nodiscard]] std::string control_socket(std::string_view key) const;
  [[nodiscard]] bool is_running(std::string_view key) const;
  // The keys of all that run, sorted.
  [[nodiscard]] std::vector<std::string> running() const;
  // The only one of these. Throws Failure.
  [[nodiscard]] std::string only_one(const std::vector<std::string>& keys) const;
  // Sends a request to its supervisor. Throws Failure: it does not run, does not answer in time, or
  // refuses.
  [[nodiscard]] json::object ask(std::string_view key, const json::object& question,
                                 const Signals& signals, tims::Duration timeout) const;
  // Hint: empty for the usual one.
  [[nodiscard]] Failure not_running(std::string_view key, std::string_view hint = {}) const;

 private:
  std::string_view what_;
  std::string folder_;
  Hints hints_;
};

// "sim-1" for "sim-1@5c0ffee5".
inline std::string_view name_of(std::string_view key) { return key.substr(0, key.find('@')); }

// The server of these requests. It handles {"do": "down"} itself: that request is answered at the
// end, by end().
class ControlServer {
 public:
  ControlServer(tims::os::File listener, const Signals& signals)
      : listener_(std::move(listener)), signals_(signals) {}

  // Waits for a request, until one of `others` is readable, or the deadline. Throws Interrupted.
  void wait(std::vector<int> others, tims::Time deadline) const;
  // Handles a waiting request, if there is one. A Failure thrown by `answer` is sent as the answer.
  void take_question(const std::function<json::object(const json::object& question)>& answer);
  [[nodiscard]] bool asked_to_end() const { return static_cast<bool>(ending_); }
  // Closes the socket and answers the request to end.
  void end(const json::object& answer);

 private:
  tims::os::File listener_;
  const Signals& signals_;
  tims::os::File ending_;  // connection of the request to end
};

// Empty if the text is not a JSON object.
json::object parse_object(std::string_view text);

}  // namespace timsctl
