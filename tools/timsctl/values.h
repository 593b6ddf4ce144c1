// What people write for a duration, a size, a message type, an address; and bytes as hex digits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/catalogue.h"
#include "tims/address.h"
#include "tims/time.h"

namespace timsctl {

// "250ms", "2s", "1.5" (seconds), "10min", "1h".
std::optional<tims::Duration> parse_duration(std::string_view text);
// "64", "4KiB", "16MiB".
std::optional<std::uint32_t> parse_size(std::string_view text);
std::optional<std::uint64_t> parse_count(std::string_view text);

// "-6", "get_status"; of a class also its own: "move". Without regard to case.
std::optional<std::int8_t> parse_type(std::string_view text,
                                      std::uint32_t class_id = rack::kEveryClass);
// "data"; empty for numbers that only a class gives a meaning.
std::string type_name(std::int8_t type);
// "move"; empty when unknown.
std::string type_name(const tims::Header& header, const tims::AddressWidths& widths);
std::string lower(std::string_view text);

// Before a router has said how its fleet divides addresses, only their form can be checked.
inline constexpr tims::AddressWidths kAnyWidths{16, 16, 16, 16};

// Everything Address::parse takes, and forms a shell leaves alone: "Ladar/3/0", "ladar/3/0:2".
std::optional<tims::Address> parse_address(std::string_view text,
                                           const tims::AddressWidths& widths = {});
// The same with "*" in any place; "Ladar" and "Ladar*" are all of a class.
std::optional<tims::AddressPattern> parse_pattern(std::string_view text,
                                                  const tims::AddressWidths& widths = {});
// The same pattern as a router understands it; the text itself when it is none.
std::string pattern_text(std::string_view text);
// The address in the form that needs no quotes in a shell: "Ladar/3/0:2".
std::string shell_name(tims::Address address, const tims::AddressWidths& widths = {});

// Pairs of digits; blanks, "0x" and ":" between them are allowed.
std::optional<std::vector<std::byte>> parse_hex(std::string_view text);
std::string to_hex(std::span<const std::byte> bytes);

}  // namespace timsctl
