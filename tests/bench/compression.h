// Compression on a slow link: scans of recorded drives between two routers on a simulated line, and
// the computing time that it adds at each end.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Scans per second that arrive over 10 Mbit/s, compressed or as they are. plan.link names the
// drive: "hokuyo", or "fr079", "intel", "aces": CARMEN logs (NAME.clf) in the folder
// $RACK_TEST_DATA.
bool measure_compressed_scans(const Plan& plan);
bool measure_plain_scans(const Plan& plan);
// The drives that are there.
std::vector<std::string> recorded_drives();

}  // namespace tims::bench
