// The two futex system calls, because a limit must not be measured with the library it applies to.
#pragma once

#include <atomic>
#include <climits>
#include <cstdint>
#include <ctime>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "tims/time.h"

namespace tims::bench {

inline void futex_wake(std::atomic<std::uint32_t>& word) {
  ::syscall(SYS_futex, &word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}
inline void futex_wait(std::atomic<std::uint32_t>& word, std::uint32_t seen,
                       Duration timeout = kForever) {
  const timespec limit{timeout.count() / 1'000'000'000, timeout.count() % 1'000'000'000};
  ::syscall(SYS_futex, &word, FUTEX_WAIT, seen, timeout == kForever ? nullptr : &limit, nullptr, 0);
}

}  // namespace tims::bench
