// What a message says, field by field, by the catalogue of messages: as a line, as JSON, as CSV,
// and to choose by. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/catalogue.h"
#include "tools/timsctl/message_text.h"

namespace timsctl {

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
std::string describe(const Message& message, WallTime time, const FieldStyle& style);

// message_json() with "body" (the name of its struct), "units" and "data"; "malformed" instead of
// "data" when the bytes are not that struct.
json::object described_json(const Message& message, WallTime time, const FieldStyle& style);
// {"vx": "mm/s", "points[].angle": "rad"}: those that have one.
json::object units_json(const rack::BodyInfo& body, bool si);

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
  void check(const rack::BodyInfo& body) const;
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

}  // namespace timsctl
