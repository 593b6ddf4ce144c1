// What a dead client left in other clients' mailboxes. Called by the router; doing it twice, or
// while senders and owner go on, is harmless.
#pragma once

#include <cstdint>

#include "shm/checked_view.h"
#include "shm/slot.h"

namespace tims::shm {

// Takes back the slots that `is_dead(writer)` was writing, and makes the owner look for messages
// that were committed but not announced. Returns the number of slots. The caller then wakes the
// owner, in case the dead client was about to.
template <typename IsDead>
std::uint32_t reclaim(const MailboxView& view, IsDead is_dead) {
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < view.geometry().slots; ++i) {
    Word64& shared = view.slot(i).word;
    const SlotWord word = SlotWord::unpack(shared.load(std::memory_order_acquire));
    if (word.state != SlotState::kWriting || !is_dead(word.writer)) continue;
    if (shared.compare_exchange(word.pack(), word.abandoned().pack(), std::memory_order_acq_rel))
      ++taken;
  }
  view.header().reclaimed.fetch_add(taken, std::memory_order_relaxed);
  view.header().rescans.fetch_add(1, std::memory_order_seq_cst);
  return taken;
}

// The owner is gone: senders must look the address up again.
inline void condemn(const MailboxView& view) {
  view.header().closed.store(1, std::memory_order_release);
}

// The owner is registered (again): a mailbox that was condemned, because its owner seemed to be
// gone, takes messages again.
inline void pardon(const MailboxView& view) {
  view.header().closed.store(0, std::memory_order_release);
}

}  // namespace tims::shm
