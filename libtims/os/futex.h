// Sleeping and waking on a word in shared memory.
#pragma once

#include <atomic>
#include <cstdint>

#include "tims/time.h"

namespace tims::os {

// Until the word is no longer `expected`, a wake-up, or the deadline. May return early.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, Time deadline);

// Clears bit 0 of the word and wakes one sleeper, as one step of the kernel: a process that dies
// here has done both or nothing.
void futex_clear_and_wake(const std::atomic<std::uint32_t>& word);

}  // namespace tims::os
