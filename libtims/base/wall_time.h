// Times of day and of the calendar, as texts. UTC unless it says otherwise: who wants local time
// adds the zone's offset (os/clock.h) first.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace tims::base {

using WallTime = std::chrono::sys_time<std::chrono::nanoseconds>;

// "2026-11-21T02:15:00.123456Z", with so many digits behind the point.
std::string rfc3339(WallTime time, int digits = 6);
// As above, with one digit to nine, or none and no point; of the years 1678 to 2261.
std::optional<WallTime> parse_rfc3339(std::string_view text);

std::string date(WallTime time);         // "2026-11-21"
std::string time_of_day(WallTime time);  // "02:15:00.123"

}  // namespace tims::base
