// A fleet that another program runs, through `timsctl sim`: as a user would have it.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/service.h"

namespace timsctl::sim {

class RunningFleet {
 public:
  struct Options {
    std::string name;  // of the fleet, whatever its file says
    std::string file;
    std::string log;                  // what it says goes there
    std::string timsctl = "timsctl";  // the program: a path, or one beside this program
    tims::Duration patience = std::chrono::seconds(20);  // for its end
  };
  // Brings it up; throws Failure when that is not possible.
  explicit RunningFleet(Options options);
  // Takes it down.
  ~RunningFleet();
  RunningFleet(const RunningFleet&) = delete;
  RunningFleet& operator=(const RunningFleet&) = delete;

  // `timsctl sim WORDS --fleet NAME`; throws Failure with its words.
  void sim(std::vector<std::string> words) const;
  // The same for its router: when it was gone, not when the command was given.
  [[nodiscard]] tims::Time kill_router(const std::string& host) const;
  // What ended by itself.
  [[nodiscard]] std::vector<std::string> ended() const;
  // Every process of it.
  [[nodiscard]] std::vector<pid_t> processes() const;
  // Copies its logs there.
  void save(const std::string& folder) const;
  // Takes it down; what is left of it then.
  std::vector<std::string> take_down();

  [[nodiscard]] std::string socket(const std::string& host) const;

 private:
  [[nodiscard]] Ran run_timsctl(std::vector<std::string> words) const;

  const Options options_;
  bool up_ = true;
  Process child_;
};

}  // namespace timsctl::sim
