// The value of one option: its kinds, the text form of each, and the limits. Independent of keys
// and files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "base/text.h"
#include "router/config/config.h"
#include "tims/result.h"

namespace tims::config {

using base::in_quotes;

enum class Kind : std::uint8_t {
  kText,         // "laptop"
  kFlag,         // true, false
  kNumber,       // 3
  kDuration,     // "250ms", "5s": ns, us, ms, s, min, h
  kSize,         // "4MiB", "262144B", 262144: B, kB, MB, GB, KiB, MiB, GiB
  kEndpoint,     // "127.0.0.1:2000", "[::1]:2000", "localhost:2000", "off"
  kLogLevel,     // "error", "warning", "info", "debug"
  kRole,         // "subsystem", "system", "top"
  kLinkKind,     // "super", "peer", "sub"
  kDestination,  // "10.9.1.1:2010", "robot1", "[::1]:2010"
  kSystem,       // 3, "*"
  kRate,         // "6MB" (per second), 0 for no limit: units of kSize
  kWidths,       // "8/8/8/8"
  kPaths,        // ["udp", "dds"]; as a single text "udp+dds"
  kClasses,      // "0/1/15/25/35/45/100"
  kCompression,  // "auto", "off", "lz4", "zstd"
};

struct Bytes {
  std::int64_t count = 0;
  auto operator<=>(const Bytes&) const = default;
};

struct Rate {
  std::int64_t bytes_per_second = 0;
  auto operator<=>(const Rate&) const = default;
};

using Value =
    std::variant<std::string, bool, std::int64_t, Duration, Bytes, std::optional<Endpoint>,
                 LogLevel, Role, LinkKind, Destination, std::optional<std::uint16_t>, Rate,
                 AddressWidths, LinkPaths, PriorityClasses, Compression>;  // in the order of Kind

// Inclusive limits of a number, the nanoseconds of a duration, the bytes of a size or rate, or
// the length of a text. A rate may also be 0.
struct Range {
  std::int64_t min = 0;
  std::int64_t max = 0;
};

// Parses the text of a value, without quotes. The error's detail continues a sentence that begins
// with the key: "must be a size such as \"4MiB\", not \"4 apples\"".
Result<Value> parse_value(Kind kind, Range range, std::string_view text);

// The second half of parse_value, for values that are already typed.
Result<void> check_range(Kind kind, Range range, const Value& value);

// The TOML form, in the largest unit that is exact: 4MiB, not 4096KiB.
std::string to_toml(const Value& value);

// "size", "duration"; "64KiB to 1GiB", empty for a kind without range; "a size such as \"4MiB\"".
std::string_view kind_name(Kind kind);
std::string range_text(Kind kind, Range range);
std::string_view kind_example(Kind kind);

}  // namespace tims::config
