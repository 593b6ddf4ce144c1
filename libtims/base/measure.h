// Durations and sizes with their units, and calendar times, in text form.
//
// Grammar of a measure: a number, immediately followed by ns, us, ms, s, min, h; or B, kB, MB, GB
// (powers of 1000), KiB, MiB, GiB (powers of 1024).
//
// A configuration file accepts whole numbers only, and every duration needs a unit. A command line
// also accepts fractions, "m" means min, and a number without a unit counts seconds.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tims/time.h"

namespace tims::base {

struct Unit {
  std::string_view name;
  std::int64_t factor;
};
// In ascending order; the first unit has the factor 1, so it divides every count.
extern const std::array<Unit, 6> kDurationUnits;
// Units for output: sizes in powers of 1024, rates in powers of 1000. Parsing accepts both.
extern const std::array<Unit, 4> kSizeUnits;
extern const std::array<Unit, 4> kRateUnits;
extern const std::array<Unit, 8> kSizeUnitsRead;

// --- reading

enum class MeasureError : std::uint8_t { kNone, kNoNumber, kNoUnit, kUnknownUnit, kTooLarge };
struct Measure {
  MeasureError error = MeasureError::kNone;
  std::int64_t count = 0;   // in the unit with the factor 1; valid without an error
  std::string_view unit{};  // as written in the text
};
// Parses a whole number, which may be negative, with one of these units.
Measure read_measure(std::string_view text, std::span<const Unit> units);

// Parses measures of a command line: "250ms", "2s", "1.5" (seconds), "10min", "1h"; "64", "4KiB",
// "1.5MB". Negative numbers are refused.
std::optional<Duration> parse_duration(std::string_view text);
std::optional<std::uint32_t> parse_size(std::string_view text);

// --- writing

// In the largest unit that expresses the count exactly: 4MiB, not 4096KiB.
std::string exact_text(std::int64_t count, std::span<const Unit> units);

inline double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

// Rounded, for people.
std::string human_count(double value);       // "812", "12.4k", "3.1M"
std::string human_bytes(double value);       // "812 B", "12.4 KiB"
std::string human_duration(double seconds);  // "14.2us", "3.10ms", "2.50s", "2m 10s", "3d 4h"
std::string human_rate(double per_second);   // "75.0", "0.20", "12.4k"

// --- calendar, in UTC unless stated otherwise: for local time, first add the offset of the time
// zone (os/clock.h)

using WallTime = std::chrono::sys_time<std::chrono::nanoseconds>;

// "2026-11-21T02:15:00.123456Z" with the given number of digits after the point.
std::string rfc3339(WallTime time, int digits = 6);
// Parses this format with up to nine digits after the point, or without a point; years 1678 to
// 2261.
std::optional<WallTime> parse_rfc3339(std::string_view text);

std::string date(WallTime time);         // "2026-11-21"
std::string time_of_day(WallTime time);  // "02:15:00.123"

}  // namespace tims::base
