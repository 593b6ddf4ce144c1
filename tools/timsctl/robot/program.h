// A program of a robot: it is started, heard, ended and started again.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/timsctl/process.h"
#include "tools/timsctl/robot/line_buffer.h"
#include "tools/timsctl/robot/restart.h"

namespace timsctl::robot {

// In the words of sd_notify(3), as far as a program speaks them.
enum class State : std::uint8_t { kDown, kStarting, kReady };

class Program {
 public:
  struct Manner {
    Restart restart = Restart::kOnFailure;
    bool tells = true;    // when it is ready; who does not is so at once
    std::string input{};  // what it reads first; its stdin ends when this object does
  };
  Program(std::string name, Launch launch, Manner manner);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::string& status() const { return status_; }    // "on", "error: ..."
  [[nodiscard]] const std::string& address() const { return address_; }  // empty: none is known
  using Parameters = std::map<std::string, std::string>;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }  // set while it ran
  [[nodiscard]] std::optional<pid_t> pid() const;

  // Throws Failure when it cannot be executed. A component that was on when it ended is told to be
  // on again, and has the parameters that were set while it ran.
  void start(tims::Time now);
  void hear(std::string_view said);  // at the status socket
  void signal(int number) const;

  // Its output and its end can be read there.
  [[nodiscard]] std::vector<int> descriptors() const;
  struct End {
    int status = 0;
    std::optional<tims::Duration> pause;  // until it starts again
  };
  // Once for each end.
  std::optional<End> ended(tims::Time now);
  // As if it had been started and had ended at once.
  End could_not_start(tims::Time now);
  // What it has written since; all of it behind ended().
  std::vector<std::string> take_lines();
  [[nodiscard]] tims::Time start_at() const { return start_at_; }  // kNever: not
  void stay_down() { start_at_ = tims::kNever; }

 private:
  End end_with(int status, tims::Time now, tims::Duration ran);

  std::string name_;
  Launch launch_;
  Manner manner_;
  RestartPolicy policy_;

  std::optional<Child> child_;
  tims::os::File input_;
  tims::os::File output_;
  LineBuffer lines_;
  State state_ = State::kDown;
  std::string status_;
  std::string address_;
  Parameters parameters_;
  Parameters kept_;  // what it goes on with after a crash
  tims::Time started_{};
  tims::Time start_at_ = tims::kNever;
};

}  // namespace timsctl::robot
