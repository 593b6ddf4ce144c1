// Starts the processes of a measurement.
#pragma once

#include <string>
#include <vector>

#include "tests/support/child_process.h"

namespace tims::bench {

inline constexpr Duration kStartLimit = std::chrono::seconds(10);

// `one_cpu`: on the last CPU.
Result<test::ChildProcess> launch(std::vector<std::string> command, bool one_cpu);

// Prints the error; returns false, for the caller to return.
bool complain(const Error& error);

}  // namespace tims::bench
