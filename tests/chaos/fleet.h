// The fleet of a run, through `timsctl sim`: as a user would have it.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/service.h"

namespace tims::chaos {

class Fleet {
 public:
  // Brings it up; throws timsctl::Failure when that is not possible. `folder` is for its log.
  Fleet(std::string name, const std::string& file, const std::string& folder);
  // Takes it down.
  ~Fleet();
  Fleet(const Fleet&) = delete;
  Fleet& operator=(const Fleet&) = delete;

  // `timsctl sim WORDS --fleet NAME`; throws timsctl::Failure with its words.
  void sim(std::vector<std::string> words) const;
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
  const std::string name_;
  const std::string log_;
  bool up_ = true;
  timsctl::Process child_;
};

}  // namespace tims::chaos
