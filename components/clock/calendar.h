// Conversion between time and clock data (specification, section 9.3), and the time by another
// clock. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "rack/proxies/clock.h"

namespace rack::clock {

// UTC, with the full year, as the original's ClockSystem sends it. recordingTime stays 0.
inline ClockData clock_of(std::chrono::seconds since_1970) {
  using namespace std::chrono;
  const auto day = floor<days>(since_1970);
  const year_month_day date{sys_days(day)};
  const hh_mm_ss time(since_1970 - day);
  return {.hour = static_cast<i32>(time.hours().count()),
          .minute = static_cast<i32>(time.minutes().count()),
          .second = static_cast<i32>(time.seconds().count()),
          .day = static_cast<i32>(static_cast<unsigned>(date.day())),
          .month = static_cast<i32>(static_cast<unsigned>(date.month())),
          .year = static_cast<i32>(static_cast<int>(date.year())),
          .utcTime = since_1970.count(),
          .dayOfWeek = static_cast<i32>(weekday(sys_days(day)).iso_encoding())};
}

// The current time by the data of another clock; none: that clock is not synchronised.
inline std::optional<std::chrono::milliseconds> time_by(const ClockData& other, TimeStamp now) {
  if (other.syncMode == 0) return std::nullopt;
  // The age is unsigned on the wire: data from the future count as age 0.
  return std::chrono::seconds(other.utcTime.raw()) +
         std::max(now - other.recordingTime, std::chrono::milliseconds(0));
}

}  // namespace rack::clock
