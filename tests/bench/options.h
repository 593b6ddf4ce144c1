// The command line for users; roles are started with a Plan instead.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"

namespace tims::bench {

struct Options {
  std::vector<std::string> scenarios;  // empty: all
  std::string csv;                     // file to write, empty: none
  bool list = false;
  bool help = false;
  bool quick = false;               // one repetition, fewer sizes, shorter
  std::optional<int> reps;          // interleaved repetitions
  std::optional<Duration> seconds;  // of each measurement; default: its shape's

  // "local_rtt" also selects "local_rtt@1cpu".
  [[nodiscard]] bool selects(const std::string& scenario) const;
};

Result<Options> parse_options(std::span<const std::string> arguments);
std::string help_text();

}  // namespace tims::bench
