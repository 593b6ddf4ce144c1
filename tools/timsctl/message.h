// A message as text for people, as JSON for programs, and back: what `msg echo` writes, `msg pub`
// sends. Pure.
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
  std::size_t bytes_max = SIZE_MAX;  // of the body
};

// -- 02:15:00.123 Ladar(3/0) -> Tool(3/7):9 type=-6 (data) priority=1 seq=0 order=little bytes=4
//    0000  01 02 03 04                                       |....|
std::string dump(const Message& message, base::WallTime time, const DumpStyle& style);
json::object message_json(const Message& message, base::WallTime time,
                          const tims::AddressWidths& widths);

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

// What a message says, field by field, by the catalogue of messages: as a line, as JSON, as CSV,
// and to choose by. Pure.

struct FieldStyle {
  tims::AddressWidths widths{};
  bool utc = false;
  bool si = false;      // numbers in SI units
  bool fields = false;  // a line a field
  bool header = false;  // also the receiver, priority, sequence number, bytes
  std::size_t elements_max = rack::kAllElements;  // of a sequence
};

// 02:15:00.123 Chassis(0/0) data recordingTime 12 ms, deltaX 0 mm, ...
// Bytes, as dump() writes them, when it is no message of the catalogue.
std::string describe(const Message& message, base::WallTime time, const FieldStyle& style);

// message_json() with "body" (the name of its struct), "units" and "data"; "malformed" instead of
// "data" when the bytes are not that struct.
json::object described_json(const Message& message, base::WallTime time, const FieldStyle& style);
// {"vx": "mm/s", "points[].angle": "rad"}: those that have one.
json::object units_json(const rack::Schema& body, bool si);

// One line of CSV for a message: fields of inner structs one by one, a sequence as JSON in one
// cell. With the line of names before it when they are others than those of the message before.
class CsvLines {
 public:
  std::string add(const json::object& described);

 private:
  std::string names_;
};

// "vx>100,omega<=0.5", "type_name=move", "points[].distance<300" (one of them).
class FieldFilter {
 public:
  FieldFilter() = default;  // lets all pass
  // Throws Failure.
  explicit FieldFilter(std::string_view text);

  // Throws Failure when a name is neither a field of the body nor one of every message.
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
};

// The body of a message that people write by name: {"vx=200", "vy=0"}. Throws Failure.
std::vector<std::byte> make_body(const rack::MessageInfo& message, std::uint32_t class_id,
                                 const std::vector<std::string>& assignments,
                                 const FieldStyle& style);

// The message of a class that is called so, or has the number. Throws Failure with what it may be.
const rack::MessageInfo& need_message(std::uint32_t class_id, std::string_view name);

// Throws Failure when it is none.
// The type of a message to a component of the class: its own names too.
std::int8_t need_type(std::string_view text, std::uint32_t class_id);
// --type, for a message to that address; GET_STATUS unless given.
std::int8_t type_to_assume(const Options& options, tims::Address to,
                           const tims::AddressWidths& widths);

}  // namespace timsctl
