// Clocks. They are read here and passed on as arguments.
#pragma once

#include <ctime>

#include "tims/time.h"

namespace tims::os {

inline Time now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return Time(std::chrono::seconds(t.tv_sec) + Duration(t.tv_nsec));
}

inline timespec to_timespec(Time time) {
  const Duration since = time.time_since_epoch();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(since);
  return {static_cast<time_t>(seconds.count()), static_cast<long>((since - seconds).count())};
}

// `now` + `wait`; kNever on overflow.
inline Time deadline_after(Duration wait) {
  const Time present = now();
  return wait >= kNever - present ? kNever : present + wait;
}

// --- Wall clock

inline std::chrono::sys_time<std::chrono::nanoseconds> wall_now() {
  return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now());
}

// Offset of local time from UTC at the given time.
inline std::chrono::seconds utc_offset(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  const auto whole = static_cast<std::time_t>(
      std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count());
  std::tm fields{};
  ::localtime_r(&whole, &fields);
  return std::chrono::seconds(fields.tm_gmtoff);
}

}  // namespace tims::os
