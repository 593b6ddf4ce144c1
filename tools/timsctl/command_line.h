// From argv to a verb and its options.
#pragma once

#include <span>
#include <string>
#include <variant>

#include "tools/timsctl/options.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

struct Command {
  const Verb* verb = nullptr;
  Options options;
};
struct Text {  // --help, --version: print it, and that was all
  std::string text;
};

// Without the program's name. Throws Failure when the command line is wrong.
std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments);

}  // namespace timsctl
