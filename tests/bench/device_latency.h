// Roles that measure the latency of a scan from the wire to a listener: a scanner that stores the
// time of the first byte in each scan, and the programs that read it.
//
// Links: "lms200": a SICK LMS200 at a terminal with a line rate of 500 kbaud, 75 scans per second.
// "cola": a SICK LMS5xx at a TCP port, 75 scans per second.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Runs until it is killed.
bool play_device(const Plan& plan);
// Both start the device, receive `plan.count` scans and print the delay of each after its line
// time, and the CPU time of the reading program in percent of a core.
//
// The driver's program at its router, and a listener whose wake-up times are measured.
bool listen_to_driver(const Plan& plan);
// Only poll() and read() until the last byte of a scan has arrived.
bool read_bare(const Plan& plan);

}  // namespace tims::bench
