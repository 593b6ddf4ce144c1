#include "tools/robot/copies.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

namespace timsctl::robot {

namespace {

std::optional<std::string_view> option_of(const tims::os::Command& command,
                                          std::string_view option) {
  const auto found = std::ranges::find_if(
      command, [&](std::string_view argument) { return argument.starts_with(option); });
  if (found == command.end()) return std::nullopt;
  return std::string_view(*found).substr(option.size());
}

}  // namespace

std::optional<std::string> component_of(const tims::os::Command& command) {
  const auto first = std::ranges::find_if(
      command, [](std::string_view argument) { return argument.starts_with("--"); });
  const auto system = option_of(command, "--system=");
  if (!system || first == command.begin()) return std::nullopt;
  const std::string& program = *std::prev(first);
  if (program.starts_with('-')) return std::nullopt;  // `ssh -oBatchMode=yes -- host ...`
  return fmt::format("{}, system {}, instance {}", program.substr(program.rfind('/') + 1), *system,
                     option_of(command, "--instance=").value_or("0"));
}

}  // namespace timsctl::robot
