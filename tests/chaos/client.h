// A component that sends numbered messages to all others, and checks every message it receives.
#pragma once

#include <string>

#include "tests/chaos/board.h"

namespace tims::chaos {

// Runs at the router of $TIMS_ROUTER until it is killed. Errors are printed to stdout.
int run_client(const SharedBoard& board, std::size_t number);

}  // namespace tims::chaos
