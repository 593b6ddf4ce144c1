// What the clock and the calendar show (specification, section 9.3), and what another clock says
// about ours. Pure.
#pragma once

#include <chrono>
#include <optional>

#include "rack/proxies/clock.h"

namespace rack::clock {

// As UTC has it, the year with all its digits, as the original's ClockSystem sends it.
// recordingTime stays 0.
ClockData clock_of(std::chrono::seconds since_1970);

// What time it is `now` by the data of another clock; none: it is not synchronised itself.
std::optional<std::chrono::milliseconds> time_by(const ClockData& other, TimeStamp now);

}  // namespace rack::clock
