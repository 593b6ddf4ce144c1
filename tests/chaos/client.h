// A component that sends numbered messages to all others, and judges every one it gets.
#pragma once

#include <string>

#include "tests/chaos/board.h"

namespace tims::chaos {

// At the router of $TIMS_ROUTER, until it is killed. What it finds wrong goes to stdout.
int run_client(const SharedBoard& board, std::size_t number);

}  // namespace tims::chaos
