// Conversion of messages to text and JSON and back: `msg pub` can send the output of `msg echo`.
// Pure.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/measure.h"
#include "rack/codec/message_text.h"
#include "rack/proxies/catalogue.h"
#include "tools/cli/connection.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace timsctl {

struct DumpStyle {
  tims::AddressWidths widths{};
  bool utc = false;
  std::size_t bytes_max = SIZE_MAX;  // largest part of the body that is printed
};

// -- 02:15:00.123 Ladar(3/0) -> Tool(3/7):9 type=-6 (data) priority=1 seq=0 order=little bytes=4
//    0000  01 02 03 04                                       |....|
std::string dump(const Message& message, base::WallTime time, const DumpStyle& style);
json::object message_json(const Message& message, base::WallTime time,
                          const tims::AddressWidths& widths);

// The data needed to send a message again.
struct Draft {
  std::int8_t type = 0;
  std::uint8_t priority = 0;
  std::uint8_t seq_nr = 0;
  bool little_endian = true;
  std::vector<std::byte> body;
};

// Whether the text is one of the two forms above.
bool is_recorded(std::string_view text);
// All messages of a text for which is_recorded() holds. Throws Failure with the line number.
std::vector<Draft> parse_recorded(std::string_view text);

// The fields of a message, decoded by the message catalogue: as a line, JSON, CSV, and for filters.
// Pure.

struct FieldStyle {
  tims::AddressWidths widths{};
  bool utc = false;
  bool si = false;      // numbers in SI units
  bool fields = false;  // one field per line
  bool header = false;  // also the receiver, priority, sequence number, bytes
  std::size_t elements_max = rack::kAllElements;  // of a sequence
};

// 02:15:00.123 Chassis(0/0) data recordingTime 12 ms, deltaX 0 mm, ...
// Bytes in the format of dump() if the message is not in the catalogue.
std::string describe(const Message& message, base::WallTime time, const FieldStyle& style);

// message_json() with "body" (the name of its struct), "units" and "data"; "malformed" instead of
// "data" if the bytes do not match that struct.
json::object described_json(const Message& message, base::WallTime time, const FieldStyle& style);
// {"vx": "mm/s", "points[].angle": "rad"}: the units of all fields that have one.
json::object units_json(const rack::Schema& body, bool si);

// One line of CSV: one cell per field of nested structs, a sequence as JSON in one cell. A header
// line precedes it if the names differ from those of the previous message.
class CsvLines {
 public:
  std::string add(const json::object& described);

 private:
  std::string names_;
};

// "vx>100,omega<=0.5", "type_name=move", "points[].distance<300" (at least one element).
class FieldFilter {
 public:
  FieldFilter() = default;  // accepts all messages
  // Throws Failure.
  explicit FieldFilter(std::string_view text, const tims::AddressWidths& widths = {});

  // Throws Failure if a name is neither a field of the body nor of every message.
  void check(const rack::Schema& body) const;
  [[nodiscard]] bool passes(const json::object& described) const;
  [[nodiscard]] bool empty() const { return conditions_.empty(); }

 private:
  struct Condition {
    std::string name;
    std::string relation;  // "=", "!=", "<", "<=", ">", ">="
    std::string value;
  };
  std::vector<Condition> conditions_;
  tims::AddressWidths widths_{};
};

// "the messages of class 128 (0x80) are not described"; empty for a known class.
std::string undescribed(std::uint32_t class_id);

// The body of a message from texts such as {"vx=200", "vy=0"}. Throws Failure.
std::vector<std::byte> make_body(const rack::MessageInfo& message, std::uint32_t class_id,
                                 const std::vector<std::string>& assignments,
                                 const FieldStyle& style);

// The message of a class with this name or number. Throws Failure with suggestions.
const rack::MessageInfo& need_message(std::uint32_t class_id, std::string_view name);

// The type of a message to a component of the class, also by a name of that class. Throws Failure
// if it is invalid.
std::int8_t need_type(std::string_view text, std::uint32_t class_id);
// The value of --type for a message to that address; GET_STATUS by default.
std::int8_t type_to_assume(const Options& options, tims::Address to,
                           const tims::AddressWidths& widths);

}  // namespace timsctl
