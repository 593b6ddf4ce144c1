#include "components/clock/calendar.h"

namespace rack::clock {

ClockData clock_of(std::chrono::seconds since_1970) {
  using namespace std::chrono;
  const auto day = floor<days>(since_1970);
  const year_month_day date{sys_days(day)};
  const hh_mm_ss time(since_1970 - day);
  const int year = static_cast<int>(date.year()) % 100;
  return {.hour = static_cast<i32>(time.hours().count()),
          .minute = static_cast<i32>(time.minutes().count()),
          .second = static_cast<i32>(time.seconds().count()),
          .day = static_cast<i32>(static_cast<unsigned>(date.day())),
          .month = static_cast<i32>(static_cast<unsigned>(date.month())),
          .year = year < 0 ? year + 100 : year,
          .utcTime = since_1970.count(),
          .dayOfWeek = static_cast<i32>(weekday(sys_days(day)).iso_encoding())};
}

}  // namespace rack::clock
