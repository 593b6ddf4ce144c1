// System calls of a process, counted by strace. It slows down each call but nothing else: where
// calls are rare it changes little, and where they are not the count says so.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/metrics.h"

namespace tims::bench {

[[nodiscard]] bool can_trace();  // strace is installed

// What to put in front of a command, so that the counts are in `file` when it has ended.
std::vector<std::string> traced(const std::string& file);
Metrics counted(const std::string& file);

}  // namespace tims::bench
