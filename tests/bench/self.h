// From a thread to itself: send, peek and release without waiting.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

bool send_to_myself(const Plan& plan);
bool loan_to_myself(const Plan& plan);

}  // namespace tims::bench
