// The clock of recording times: the wall clock, as in the original, so that data of several hosts
// can be compared when their clocks agree.
#pragma once

#include <ctime>

#include "rack/codec/quantity.h"

namespace rack {

inline TimeStamp time_stamp() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return TimeStamp::of(std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec)));
}

}  // namespace rack
