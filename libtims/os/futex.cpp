#include "os/futex.h"

#include <ctime>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "os/clock.h"

namespace tims::os {

void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, Time deadline) {
  timespec until{};
  timespec* limit = nullptr;
  if (deadline != kNever) {
    until = to_timespec(deadline);
    limit = &until;
  }
  // BITSET: the deadline is absolute, on the monotonic clock.
  ::syscall(SYS_futex, &word, FUTEX_WAIT_BITSET, expected, limit, nullptr, FUTEX_BITSET_MATCH_ANY);
}

void futex_clear_and_wake(const std::atomic<std::uint32_t>& word) {
  // The comparison is never true: nobody is woken a second time.
  const std::uint32_t operation = FUTEX_OP(FUTEX_OP_ANDN, 1, FUTEX_OP_CMP_LT, 0);
  const std::uintptr_t second_wakes = 0;
  ::syscall(SYS_futex, &word, FUTEX_WAKE_OP, 1, second_wakes, &word, operation);
}

}  // namespace tims::os
