// A message as text for people, as JSON for programs, and back: what `msg echo` writes, `msg pub`
// sends. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/timsctl/connection.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/json.h"

namespace timsctl {

struct DumpStyle {
  tims::AddressWidths widths{};
  bool utc = false;
  std::size_t bytes_max = SIZE_MAX;  // of the body
};

// -- 02:15:00.123 Ladar(3/0) -> Tool(3/7):9 type=-6 (data) priority=1 seq=0 order=little bytes=4
//    0000  01 02 03 04                                       |....|
std::string dump(const Message& message, WallTime time, const DumpStyle& style);
json::object message_json(const Message& message, WallTime time, const tims::AddressWidths& widths);

// {"name": "Ladar(3/0)", "raw": "0x03140000"}
json::object address_json(tims::Address address, const tims::AddressWidths& widths);

// What is needed to send it again.
struct Draft {
  std::int8_t type = 0;
  std::uint8_t priority = 0;
  std::uint8_t seq_nr = 0;
  bool little_endian = true;
  std::vector<std::byte> body;
};

// Whether the text is one of the two forms above.
bool is_recorded(std::string_view text);
// All messages of the text, which is_recorded. Throws Failure that names the line.
std::vector<Draft> parse_recorded(std::string_view text);

}  // namespace timsctl
