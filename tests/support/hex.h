// Bytes as hex digits, the way the specification and the recordings write them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tims::test {

std::string to_hex(std::span<const std::byte> bytes);
// Nullopt for an odd number of digits and for anything that is no digit.
std::optional<std::vector<std::byte>> from_hex(std::string_view text);

}  // namespace tims::test
