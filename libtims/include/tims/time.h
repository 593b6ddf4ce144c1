// Time in the whole project: integer nanoseconds on the monotonic clock.
#pragma once

#include <chrono>
#include <cstdint>

namespace tims {

using Duration = std::chrono::nanoseconds;

struct MonotonicClock {  // CLOCK_MONOTONIC; read only in os/ and io/, passed on as an argument
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<MonotonicClock>;
  static constexpr bool is_steady = true;
};
using Time = MonotonicClock::time_point;

inline constexpr Time kNever = Time::max();
inline constexpr Duration kForever = Duration::max();  // as a timeout: no limit

}  // namespace tims
