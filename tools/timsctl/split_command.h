// A program and its arguments. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace timsctl {

using CommandLine = std::vector<std::string>;

// "tims-demo ladar --at 'Ladar(1/0)'" as a shell would cut it. nothing: a quote is not closed.
std::optional<CommandLine> split_command(std::string_view text);

}  // namespace timsctl
