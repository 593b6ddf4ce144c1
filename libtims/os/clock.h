// The monotonic clock: read here, passed on as an argument.
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

// `now` + `wait`, kNever where that is beyond the end of time.
inline Time deadline_after(Duration wait) {
  const Time present = now();
  return wait >= kNever - present ? kNever : present + wait;
}

}  // namespace tims::os
