// Numbers as people read them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tims/time.h"

namespace timsctl {

using WallTime = std::chrono::sys_time<std::chrono::nanoseconds>;

inline double seconds(tims::Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

std::string human_count(double value);       // "812", "12.4k", "3.1M"
std::string human_bytes(double value);       // "812 B", "12.4 KiB"
std::string human_duration(double seconds);  // "14.2us", "3.10ms", "2.50s", "2m 10s", "3d 4h"
std::string human_rate(double per_second);   // "75.0", "0.20", "12.4k"

std::string rfc3339(WallTime time);                            // "2026-11-21T02:15:00.123456Z"
std::string time_of_day(WallTime time, bool utc);              // "02:15:00.123"
std::optional<WallTime> parse_rfc3339(std::string_view text);  // of UTC, as written above
// The time of day of an RFC 3339 time; the text itself when it is none.
std::string local_time(std::string_view rfc3339_text, bool utc);
WallTime wall_now();
std::chrono::sys_time<std::chrono::milliseconds> wall_now_ms();

// Text of others on a terminal: control characters and broken UTF-8 become '?'. A name must not
// move the cursor.
std::string printable(std::string_view text);
// The same for texts of several lines.
std::string printable_lines(std::string_view text);
// Columns the text takes on a terminal, one for each character.
std::size_t display_width(std::string_view text);

}  // namespace timsctl
