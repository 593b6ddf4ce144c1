// The clocks of a component.
#pragma once

#include <ctime>

#include "rack/codec/quantity.h"
#include "tims/time.h"

namespace rack {

// The clock of deadlines and periods.
inline tims::Time now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return tims::Time(std::chrono::seconds(now.tv_sec) + tims::Duration(now.tv_nsec));
}

// The clock of recording times: the wall clock, as in the original, so that data of several hosts
// can be compared when their clocks agree.
inline TimeStamp time_stamp() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return TimeStamp::of(std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec)));
}

}  // namespace rack
