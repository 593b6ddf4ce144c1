// A fleet that another program runs through `timsctl sim`, like a user.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/service.h"

namespace timsctl::sim {

class RunningFleet {
 public:
  struct Options {
    std::string name;  // overrides the name in the fleet file
    std::string file;
    std::string log;                  // file for its output
    std::string timsctl = "timsctl";  // a path, or a program in the folder of this program
    tims::Duration patience = std::chrono::seconds(20);  // time limit for the end
  };
  // Starts the fleet. Throws Failure if that is not possible.
  explicit RunningFleet(Options options);
  // Stops the fleet.
  ~RunningFleet();
  RunningFleet(const RunningFleet&) = delete;
  RunningFleet& operator=(const RunningFleet&) = delete;

  // Runs `timsctl sim ARGUMENTS --fleet NAME`. Throws Failure with its output.
  void sim(std::vector<std::string> arguments) const;
  // Kills the router of a host; returns the time at which it had ended, not that of the command.
  [[nodiscard]] tims::Time kill_router(const std::string& host) const;
  // Programs that ended unexpectedly.
  [[nodiscard]] std::vector<std::string> ended() const;
  // All processes of the fleet.
  [[nodiscard]] std::vector<pid_t> processes() const;
  // Copies all files but private keys to the folder.
  void save(const std::string& folder) const;
  // Stops the fleet and returns its remains.
  std::vector<std::string> take_down();

  [[nodiscard]] std::string socket(const std::string& host) const;

 private:
  [[nodiscard]] Ran run_timsctl(std::vector<std::string> arguments) const;

  const Options options_;
  bool up_ = true;
  Process child_;
};

}  // namespace timsctl::sim
