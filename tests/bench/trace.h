// System calls of a process, counted by strace. It slows down only system calls: if they are rare,
// it has little effect, and otherwise the count shows it.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/metrics.h"

namespace tims::bench {

[[nodiscard]] bool can_trace();  // strace is installed

// The prefix of a command that writes the counts to `file` when it exits.
std::vector<std::string> traced(const std::string& file);
Metrics counted(const std::string& file);

}  // namespace tims::bench
