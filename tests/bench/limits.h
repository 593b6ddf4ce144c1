// Limits that are roles of their own: what the machine can do when nothing but the bare act is
// done. The ring (shared_ring.h) and the relay (relay.h) are the other limits.
#pragma once

#include <cstdint>
#include <functional>

#include "tests/bench/plan.h"

namespace tims::bench {

// A bare hand-over: two words in shared memory, both processes sleep on a futex. Nothing is copied.
bool futex_ping(const Plan& plan);
bool futex_echo(const Plan& plan);

// Calls `pass` for the time of the plan; it moves messages and returns how many. Prints the rate.
void measure_passes(const Plan& plan, const std::function<std::uint64_t()>& pass);

// memcpy in one thread, through 64 MiB: from memory that is not in a cache.
bool copy_through_memory(const Plan& plan);
// memcpy in one thread, from one place into as many as a mailbox has slots: what sending copies.
bool copy_into_slots(const Plan& plan);

}  // namespace tims::bench
