// Parses addresses, address patterns, classes and message types as users write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/catalogue.h"
#include "tims/address.h"
#include "tims/time.h"
#include "tools/cli/output.h"

namespace timsctl {

// "-6", "get_status", or a message of the class: "move". Case-insensitive.
std::optional<std::int8_t> parse_type(std::string_view text,
                                      std::uint32_t class_id = rack::kEveryClass);
// "data"; empty for numbers whose meaning depends on the class.
std::string type_name(std::int8_t type);
// "move"; empty when unknown.
std::string type_name(const tims::Header& header, const tims::AddressWidths& widths);

// Until the address widths of the fleet are known from a router, only the form can be checked.
inline constexpr tims::AddressWidths kAnyWidths{16, 16, 16, 16};

// Accepts what Address::parse accepts, and forms without shell quoting: "Ladar/3/0", "ladar/3/0:2".
std::optional<tims::Address> parse_address(std::string_view text,
                                           const tims::AddressWidths& widths = {});
// The same with "*" in any position; "Ladar" and "Ladar*" match the whole class.
std::optional<tims::AddressPattern> parse_pattern(std::string_view text,
                                                  const tims::AddressWidths& widths = {});
// The pattern in the form that a router accepts; the unchanged text if it is not a pattern.
std::string pattern_text(std::string_view text);
// The address in the form that needs no quotes in a shell: "Ladar/3/0:2".
std::string shell_name(tims::Address address, const tims::AddressWidths& widths = {});

// The text with the names of classes instead of "unknown[80]", if a message file of this host gives
// them names: other programs may not have read it.
std::string with_class_names(std::string text);

// Throw Failure if the argument is invalid.
tims::Address need_address(std::string_view text, const tims::AddressWidths& widths);
std::vector<tims::Address> need_addresses(const std::vector<std::string>& texts,
                                          const tims::AddressWidths& widths);
tims::AddressPattern need_pattern(std::string_view text, const tims::AddressWidths& widths);
// A class by name ("Chassis") or by an address ("Chassis/0/0").
std::uint32_t need_class(std::string_view text);

// Splits the text at each `between`; parts may be empty.
std::vector<std::string_view> parts_of(std::string_view text, char between);

// {"name": "Ladar(3/0)", "raw": "0x03140000"}
json::object address_json(tims::Address address, const tims::AddressWidths& widths);

}  // namespace timsctl
