// Date and time of day (specification, section 9.3).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct ClockData {
  TimeStamp recordingTime = 0;
  i32 hour = 0;                // 0 to 23
  i32 minute = 0;              // 0 to 59
  i32 second = 0;              // 0 to 59
  i32 day = 1;                 // 1 to 31
  i32 month = 1;               // 1 to 12
  i32 year = 0;                // all four digits
  Seconds<i64> utcTime = 0;    // since 1970
  i32 dayOfWeek = 1;           // 1: Monday to 7: Sunday
  i32 syncMode = 0;            // 0: none, 1: remote
  Milliseconds<i32> varT = 0;  // standard deviation
};

using ClockProxy = DataProxy<ClockData, tims::class_id::kClock>;

}  // namespace rack
