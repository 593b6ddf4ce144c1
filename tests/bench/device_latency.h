// Roles that measure how long a scan takes from the wire to a listener: a scanner that writes into
// each scan when it sends its first byte, and who reads it.
//
// Links: "lms200": a SICK LMS200 at a terminal with the rate of its line, 500 kbaud, 75 scans a
// second. "cola": a SICK LMS5xx at a TCP port, 75 scans a second.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Until it is killed.
bool play_device(const Plan& plan);
// Both start the device, take `plan.count` scans and print how much later than their line time each
// of them was there, and what the reading program cost, in percent of a core.
//
// The driver's program at its router, and a listener of it, whose wake-ups count.
bool listen_to_driver(const Plan& plan);
// poll() and read() until the last byte of a scan is there, nothing else.
bool read_bare(const Plan& plan);

}  // namespace tims::bench
