// The command line for users; roles are started with a Plan instead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/argument_parser.h"

namespace tims::bench {

struct Options {
  std::vector<std::string> scenarios;  // empty: all
  std::string csv;                     // file to write, empty: none
  bool list = false;
  bool quick = false;                 // one repetition, fewer sizes, shorter
  std::optional<std::uint64_t> reps;  // interleaved repetitions
  std::optional<double> seconds;      // of each measurement; default: its shape's

  // "local_rtt" also selects "local_rtt@1cpu".
  [[nodiscard]] bool selects(const std::string& scenario) const;
};

void add_options(timsctl::ArgumentParser& parser, Options& options);

}  // namespace tims::bench
