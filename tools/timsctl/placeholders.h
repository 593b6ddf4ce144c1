// What may stand in braces in the commands of a file: "{system}" for a robot's number. A brace that
// is opened and not closed is none of them. Pure.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace timsctl {

using Placeholders = std::map<std::string, std::string, std::less<>>;

// The first one that is not known.
std::optional<std::string> unknown_placeholder(std::string_view text,
                                               std::span<const std::string> known);
// What is not known becomes nothing.
std::string filled_in(std::string_view text, const Placeholders& values);

}  // namespace timsctl
