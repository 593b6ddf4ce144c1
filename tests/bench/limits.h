// Limits with their own roles: the performance of the machine for the basic operation alone. The
// other limits are the ring (shared_ring.h) and the relay (relay.h).
#pragma once

#include <cstdint>
#include <functional>

#include "tests/bench/plan.h"

namespace tims::bench {

// A bare hand-over: two futexes in shared memory on which the processes sleep. Nothing is copied.
bool futex_ping(const Plan& plan);
bool futex_echo(const Plan& plan);

// Calls `pass` for the time of the plan; it transfers messages and returns their number. Prints the
// rate.
void measure_passes(const Plan& plan, const std::function<std::uint64_t()>& pass);

// memcpy in one thread through 64 MiB, from memory that is not cached.
bool copy_through_memory(const Plan& plan);
// memcpy in one thread from one place into as many as a mailbox has slots, like the copies of send.
bool copy_into_slots(const Plan& plan);

}  // namespace tims::bench
