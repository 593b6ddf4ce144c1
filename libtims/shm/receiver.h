// The owner's side of a mailbox. One thread at a time may take; release() may be called by any
// thread of the owner at any time.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "shm/checked_view.h"
#include "shm/priority_index.h"
#include "tims/message.h"

namespace tims::shm {

// A message that belongs to the owner until it is released.
struct Taken {
  Hint hint;
  Header header;
  std::span<const std::byte> body;
};

class Receiver {
 public:
  explicit Receiver(const MailboxView& view);

  // The most important message, the oldest of its priority; nothing when none waits.
  std::optional<Taken> take();
  // Undoes take(): the message is first again.
  void put_back(const Taken& taken);
  void release(Hint hint);
  // Throws away what is waiting at the moment; returns how many.
  std::size_t clean();

  // Before sleeping: arm(), and only if nothing_came() wait until MailboxHeader::sleep is no
  // longer the value that arm() returned; then disarm().
  std::uint32_t arm();
  void disarm();
  [[nodiscard]] bool nothing_came() const;

  void close() { view_.header().closed.store(1, std::memory_order_release); }
  [[nodiscard]] bool closed() const {
    return view_.header().closed.load(std::memory_order_acquire) != 0;
  }
  [[nodiscard]] const MailboxView& view() const { return view_; }

 private:
  void ingest();
  void drain_ring();
  std::optional<Taken> next();
  void rescan();
  [[nodiscard]] Stamp stamp_at(std::uint64_t tail) const;
  [[nodiscard]] bool is_possible(Stamp stamp) const;
  void collect_abandoned(std::uint32_t index, SlotWord word);
  void make_room();
  void push_free(Hint hint);
  [[nodiscard]] bool still_waiting(Hint hint) const;

  MailboxView view_;
  PriorityIndex index_;
  std::uint64_t arrival_head_ = 0;
  std::uint64_t rescans_seen_ = 0;
  std::uint32_t sleeps_ = 0;
  Word64 free_tail_;
  Word64 free_head_seen_{0};
};

// Readable messages at this moment, by looking at every slot.
std::uint64_t waiting(const MailboxView& view);

}  // namespace tims::shm
