// A complete run: all selected cases, with interleaved repetitions of all contenders.
#pragma once

#include <string>

#include "tests/bench/options.h"

namespace tims::bench {

// The exit status: 0 if everything could be measured, independent of the results.
int run_bench(const Options& options, const std::string& program);

}  // namespace tims::bench
