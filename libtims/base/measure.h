// Durations and sizes with their units, and times of the calendar, as people write and read them.
//
// One grammar of measures: a number, and right behind it ns, us, ms, s, min, h; or B, kB, MB, GB
// (powers of 1000), KiB, MiB, GiB (powers of 1024).
//
// A configuration is strict about it: whole numbers, every duration says its unit. On a command
// line also fractions are fine, "m" is min, and a bare number counts seconds.
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
// Ascending; the first one always divides.
extern const std::array<Unit, 6> kDurationUnits;
// To write sizes with: powers of 1024; rates: of 1000. Reading knows both.
extern const std::array<Unit, 4> kSizeUnits;
extern const std::array<Unit, 4> kRateUnits;
extern const std::array<Unit, 8> kSizeUnitsRead;

// --- reading

enum class MeasureError : std::uint8_t { kNone, kNoNumber, kNoUnit, kUnknownUnit, kTooLarge };
struct Measure {
  MeasureError error = MeasureError::kNone;
  std::int64_t count = 0;   // of the unit with the factor 1; without an error
  std::string_view unit{};  // as it is written
};
// A whole number, which may be negative, and one of these units.
Measure read_measure(std::string_view text, std::span<const Unit> units);

// As on a command line: "250ms", "2s", "1.5" (seconds), "10min", "1h"; "64", "4KiB", "1.5MB". None
// is negative.
std::optional<Duration> parse_duration(std::string_view text);
std::optional<std::uint32_t> parse_size(std::string_view text);

// --- writing

// In the largest unit that says it exactly: 4MiB, not 4096KiB.
std::string exact_text(std::int64_t count, std::span<const Unit> units);

inline double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

// Rounded, for people.
std::string human_count(double value);       // "812", "12.4k", "3.1M"
std::string human_bytes(double value);       // "812 B", "12.4 KiB"
std::string human_duration(double seconds);  // "14.2us", "3.10ms", "2.50s", "2m 10s", "3d 4h"
std::string human_rate(double per_second);   // "75.0", "0.20", "12.4k"

// --- the calendar, in UTC unless it says otherwise: who wants local time adds the zone's offset
// (os/clock.h) first

using WallTime = std::chrono::sys_time<std::chrono::nanoseconds>;

// "2026-11-21T02:15:00.123456Z", with so many digits behind the point.
std::string rfc3339(WallTime time, int digits = 6);
// As above, with one digit to nine, or none and no point; of the years 1678 to 2261.
std::optional<WallTime> parse_rfc3339(std::string_view text);

std::string date(WallTime time);         // "2026-11-21"
std::string time_of_day(WallTime time);  // "02:15:00.123"

}  // namespace tims::base
