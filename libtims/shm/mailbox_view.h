// A mailbox in shared memory as this process may touch it. What the other side wrote is read once,
// checked, and kept here; afterwards every index goes through a function that cannot leave the
// mapping, whatever anybody writes into it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shm/layout.h"
#include "shm/slot.h"
#include "tims/result.h"

namespace tims::shm {

class MailboxView {
 public:
  MailboxView() = default;

  // A mailbox that somebody else laid out at `offset` of `mapping`. kBadLayout says what is wrong.
  static Result<MailboxView> open(std::span<std::byte> mapping, std::uint64_t offset);

  struct Options {
    Address address;
    std::uint32_t slots = 1;
    std::uint32_t message_max = kHeaderSize;
    std::uint32_t long_places = 0;  // 0: one for each slot
    WakeKind wake = WakeKind::kFutex;
    std::uint32_t owner_pid = 0;
  };
  // Lays out a new mailbox in zeroed memory; the caller has checked sizes and alignment.
  static MailboxView create(std::span<std::byte> mapping, std::uint64_t offset,
                            const Options& options);

  [[nodiscard]] MailboxHeader& header() const { return *header_; }
  [[nodiscard]] const Geometry& geometry() const { return geometry_; }
  [[nodiscard]] WakeKind wake() const { return wake_; }
  [[nodiscard]] Address address() const { return address_; }

  [[nodiscard]] Word64& arrival(std::uint64_t position) const {
    return arrival_[position & (geometry_.ring - 1)];
  }
  [[nodiscard]] Word64& free(std::uint64_t position) const {
    return free_[position & (geometry_.ring - 1)];
  }
  // Precondition: index < geometry().slots.
  [[nodiscard]] SlotHeader& slot(std::uint32_t index) const {
    // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.UndefReturn): a view that was made has slots
    return *reinterpret_cast<SlotHeader*>(slots_ + index * geometry_.stride);
  }
  // The header of a slot's message: kHeaderSize bytes.
  [[nodiscard]] std::byte* message_header(std::uint32_t index) const {
    return slots_ + index * geometry_.stride + sizeof(SlotHeader);
  }
  // Its body, when it has at most geometry().short_max bytes.
  [[nodiscard]] std::byte* short_body(std::uint32_t index) const {
    return message_header(index) + kHeaderSize;
  }
  // A longer one. Precondition: place < geometry().long_places.
  [[nodiscard]] std::byte* long_body(std::uint32_t place) const {
    return long_ + place * geometry_.long_stride;
  }
  // Who has a shared place: geometry().long_places of them.
  [[nodiscard]] Word64& holder(std::uint32_t place) const { return holders_[place]; }
  void prefetch(std::uint32_t index) const {
    const std::byte* at = slots_ + index * geometry_.stride;
    __builtin_prefetch(at, 1);
    __builtin_prefetch(at + kLine, 1);
  }

 private:
  MailboxView(std::byte* base, const Geometry& geometry);

  MailboxHeader* header_ = nullptr;
  Word64* arrival_ = nullptr;
  Word64* free_ = nullptr;
  Word64* holders_ = nullptr;
  std::byte* slots_ = nullptr;
  std::byte* long_ = nullptr;
  Geometry geometry_;
  WakeKind wake_ = WakeKind::kFutex;
  Address address_;
};

// --- What a dead client left in other clients' mailboxes. Called by the router; doing it twice, or
// while senders and owner go on, is harmless.

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
