// What the clock and the calendar show (specification, section 9.3). Pure.
#pragma once

#include "proxies/clock.h"

namespace rack::clock {

// As UTC has it; recordingTime stays 0.
ClockData clock_of(std::chrono::seconds since_1970);

}  // namespace rack::clock
