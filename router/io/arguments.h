// The command line of tims-router. Pure.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tims/result.h"

namespace tims::io {

struct Arguments {
  enum class Action : std::uint8_t { kRun, kCheck, kPrintConfig, kVersion, kHelp };
  Action action = Action::kRun;
  std::string config_path{};            // empty: none
  std::vector<std::string> settings{};  // key=value
};

Result<Arguments> parse_arguments(std::span<const char* const> argv);

// Usage text, up to the list of options.
std::string usage();

}  // namespace tims::io
