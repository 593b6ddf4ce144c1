// A whole run: all chosen cases, repetitions of all contenders interleaved.
#pragma once

#include <string>

#include "tests/bench/options.h"

namespace tims::bench {

// The exit status: 0 when everything could be measured, whatever the figures say.
int run_bench(const Options& options, const std::string& program);

}  // namespace tims::bench
