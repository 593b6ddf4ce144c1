// Which messages a rule is about: "commands", "replies", "look", "drive", "chassis.move", "-6",
// "20..29", "change".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/address.h"
#include "tims/message.h"

namespace tims::policy {

// What a question to a router, or to the configuration agent beside it, needs (type ADMIN_REQUEST):
// reading, changing the router or its files, a login for a browser, or the driving lease of a
// robot; agreeing on a change of files that was begun at several hosts. Also the right to have a
// message traced.
enum class Right : std::uint8_t { kNone, kLook, kChange, kLogin, kTrace, kDrive, kAgree };

// What rules decide about.
struct Query {
  Address dest{};
  Address src{};
  std::int8_t type = 0;
  bool is_sample = false;      // of a stream (flag STREAM)
  Right right = Right::kNone;  // of a question to a router

  // The class that a type belongs to: of the receiver of a command, of the sender of all others.
  [[nodiscard]] std::uint16_t class_id(const AddressWidths& widths) const {
    return static_cast<std::uint16_t>((type > 0 ? dest : src).fields(widths).class_id);
  }
  bool operator==(const Query&) const = default;
};

// One item of a rule's `types`.
class TypePattern {
 public:
  static std::string problem(std::string_view text);  // for users; empty: it is a pattern
  static std::optional<TypePattern> parse(std::string_view given);

  [[nodiscard]] bool matches(const Query& query, std::uint16_t class_id) const;
  // True when it matches whatever the other one matches. False negatives are possible.
  [[nodiscard]] bool covers(const TypePattern& other) const;
  // "*": every message and every right.
  [[nodiscard]] bool is_everything() const { return rights_ == kAllRights; }
  bool operator==(const TypePattern&) const = default;

 private:
  struct Span {
    std::uint16_t class_id = 0;  // kEveryClass: of any class
    std::int8_t first = 0;
    std::int8_t last = 0;
    bool operator==(const Span&) const = default;
  };
  static constexpr std::uint8_t kAllRights = 0xFF;

  std::vector<Span> spans_;
  std::uint8_t rights_ = 0;  // bit Right
};

// The type of a message by its name ("move", "chassis.move") or number; `class_id`: of the
// receiver. Rights ("look", "change", "login") are questions to a router.
std::optional<Query> parse_type(std::string_view given, std::uint16_t class_id);

}  // namespace tims::policy
