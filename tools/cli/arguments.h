// What people write for an address, a pattern of addresses, a class, a message type.
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

// "-6", "get_status"; of a class also its own: "move". Without regard to case.
std::optional<std::int8_t> parse_type(std::string_view text,
                                      std::uint32_t class_id = rack::kEveryClass);
// "data"; empty for numbers that only a class gives a meaning.
std::string type_name(std::int8_t type);
// "move"; empty when unknown.
std::string type_name(const tims::Header& header, const tims::AddressWidths& widths);

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

// Throw Failure when the argument is none.
tims::Address need_address(std::string_view text, const tims::AddressWidths& widths);
std::vector<tims::Address> need_addresses(const std::vector<std::string>& texts,
                                          const tims::AddressWidths& widths);
tims::AddressPattern need_pattern(std::string_view text, const tims::AddressWidths& widths);
// A class by name ("Chassis"), or that of an address ("Chassis/0/0").
std::uint32_t need_class(std::string_view text);

// Between every two of these characters, empty ones too.
std::vector<std::string_view> parts_of(std::string_view text, char between);

// {"name": "Ladar(3/0)", "raw": "0x03140000"}
json::object address_json(tims::Address address, const tims::AddressWidths& widths);

}  // namespace timsctl
