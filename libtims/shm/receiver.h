// The owner's side of a mailbox. Only one thread at a time may call take(); any thread of the owner
// may call release() at any time.
//
// The owner keeps the order in private memory (PriorityIndex) and checks every hint against the
// slot's state word when it takes the message. The hint of a message that was replaced is skipped.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "shm/layout.h"
#include "shm/slot.h"
#include "tims/message.h"
#include "wire/header.h"

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

  // Takes the most important message, the oldest of its priority; nothing when none waits.
  std::optional<Taken> take();
  // Undoes take(): the message is first again.
  void put_back(const Taken& taken);
  void release(Hint hint);
  // Discards the messages that are waiting now; returns their number.
  std::size_t clean();

  // Before sleeping: call arm(). Only if nothing_came(), wait until MailboxHeader::sleep differs
  // from the value that arm() returned; then call disarm(). The closed flag is not checked here:
  // every process that shares the memory can write it, and it must not keep the owner awake. The
  // owner knows itself whether it has closed the mailbox.
  std::uint32_t arm();
  void disarm();
  [[nodiscard]] bool nothing_came() const;
  // For an owner that is woken by a doorbell. True: the mailbox is armed, and nothing has to be
  // done until the doorbell rings. False: call take() again.
  [[nodiscard]] bool rest();

  void close() { view_.header().closed.store(1, std::memory_order_release); }
  [[nodiscard]] bool closed() const {
    return view_.header().closed.load(std::memory_order_acquire) != 0;
  }
  [[nodiscard]] const MailboxView& view() const { return view_; }

 private:
  [[nodiscard]] bool first_is_in_hand() const;
  [[nodiscard]] const std::byte* body_of(std::uint32_t index, std::uint32_t length) const;
  std::optional<Taken> take_front();
  void ingest();
  void fetch_hints();
  void drain_ring();
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

// --- hot path; seldom used functions are in receiver.cpp ---

// Looks at the arrival ring only when it may contain something more important: reading it takes the
// cache line away from the senders.
inline std::optional<Taken> Receiver::take() {
  bool looked = false;
  for (;;) {
    if (!looked && !first_is_in_hand()) {
      ingest();
      looked = true;
    }
    if (index_.empty()) return std::nullopt;
    if (auto taken = take_front()) return taken;
  }
}

// No message in the ring is more important than the first one here, or of equal priority and older.
inline bool Receiver::first_is_in_hand() const {
  return !index_.empty() && view_.header().highest.load(std::memory_order_acquire) <=
                                std::uint32_t{index_.front().priority};
}

// Nothing: the message was replaced, or its sender wrote invalid data.
inline std::optional<Taken> Receiver::take_front() {
  const Hint hint = index_.front();
  index_.pop();
  if (!index_.empty()) view_.prefetch(index_.front().index);
  const SlotWord word = hint.readable();
  if (!view_.slot(hint.index)
           .word.compare_exchange(word.pack(), word.locked().pack(), std::memory_order_acq_rel))
    return std::nullopt;
  const Header header =
      wire::decode_header(wire::ConstHeaderBytes(view_.message_header(hint.index), kHeaderSize));
  const std::byte* body = body_of(hint.index, header.length);
  if (body == nullptr) {
    view_.header().reclaimed.fetch_add(1, std::memory_order_relaxed);
    release(hint);
    return std::nullopt;
  }
  Word64& received = view_.header().received;
  received.store(received.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  return Taken{hint, header, {body, header.body_size()}};
}

// Checks the length and the place, which the sender wrote, before they are used. Null: invalid.
inline const std::byte* Receiver::body_of(std::uint32_t index, std::uint32_t length) const {
  const Geometry& geometry = view_.geometry();
  if (length < kHeaderSize || length > geometry.message_max) return nullptr;
  const std::byte* in_slot = view_.short_body(index);
  if (length - kHeaderSize <= geometry.short_max) return in_slot;
  std::uint32_t place = 0;
  std::memcpy(&place, in_slot, sizeof place);
  return place < geometry.long_places ? view_.long_body(place) : nullptr;
}

inline void Receiver::release(Hint hint) {
  const SlotWord word{.generation = hint.generation};
  view_.slot(hint.index).word.store(word.pack(), std::memory_order_release);
  push_free(hint);
}

// The free ring only contains hints: when it is full, a sender finds the slot by scanning all
// slots.
inline void Receiver::push_free(Hint hint) {
  // maximum number of threads past the check at the same time
  constexpr std::uint32_t kMargin = kRingSpare / 2;
  const Geometry& geometry = view_.geometry();
  const std::uint64_t limit = geometry.ring - kMargin;
  if (free_tail_.load(std::memory_order_relaxed) -
          free_head_seen_.load(std::memory_order_relaxed) >=
      limit) {
    const std::uint64_t head = view_.header().free_head.load(std::memory_order_acquire);
    free_head_seen_.store(head, std::memory_order_relaxed);
    if (free_tail_.load(std::memory_order_relaxed) - head >= limit) return;
  }
  const std::uint64_t position = free_tail_.fetch_add(1, std::memory_order_relaxed);
  hint.lap = geometry.lap_of(position);
  hint.priority = 0;
  view_.free(position).store(hint.pack(), std::memory_order_release);
}

inline void Receiver::ingest() {
  fetch_hints();
  if (index_.empty() || first_is_in_hand()) return;
  // It was raised for messages that are gone. Lower it first and check again afterwards: see
  // raise_highest().
  view_.header().highest.store(0, std::memory_order_seq_cst);
  fetch_hints();
}

// Moves hints from the shared ring into the private order. Checks for missing hints again
// afterwards: a hint that arrived may be younger than one that is missing.
inline void Receiver::fetch_hints() {
  const Word64& rescans = view_.header().rescans;
  if (rescans.load(std::memory_order_acquire) == rescans_seen_) drain_ring();
  if (rescans.load(std::memory_order_acquire) != rescans_seen_) rescan();
}

// At most one lap.
inline void Receiver::drain_ring() {
  const Geometry& geometry = view_.geometry();
  const std::uint64_t before = arrival_head_;
  for (std::uint32_t n = 0; n < geometry.ring; ++n) {
    const Hint hint = Hint::unpack(view_.arrival(arrival_head_).load(std::memory_order_seq_cst));
    if (hint.lap != geometry.lap_of(arrival_head_)) break;
    ++arrival_head_;
    if (hint.index >= geometry.slots) continue;
    make_room();
    index_.put(hint);
  }
  if (arrival_head_ != before)
    view_.header().arrival_head.store(arrival_head_, std::memory_order_release);
}

inline std::uint32_t Receiver::arm() {
  sleeps_ += 2;
  const std::uint32_t armed = sleeps_ | 1;
  view_.header().sleep.store(armed, std::memory_order_seq_cst);
  return armed;
}

inline void Receiver::disarm() { view_.header().sleep.store(sleeps_, std::memory_order_relaxed); }

inline bool Receiver::nothing_came() const {
  const Hint next = Hint::unpack(view_.arrival(arrival_head_).load(std::memory_order_seq_cst));
  return next.lap != view_.geometry().lap_of(arrival_head_) &&
         view_.header().rescans.load(std::memory_order_seq_cst) == rescans_seen_;
}

inline bool Receiver::rest() {
  arm();
  if (nothing_came()) return true;
  disarm();
  return false;
}

// Number of readable messages now, by scanning all slots.
std::uint64_t waiting(const MailboxView& view);

// Counters of a mailbox; the fields are explained in tims/mailbox.h.
struct Counters {
  std::uint64_t received = 0;
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;
  std::uint64_t too_big = 0;
  std::uint64_t reclaimed = 0;

  Counters& operator+=(const Counters& more);
};
Counters counters(const MailboxView& view);

}  // namespace tims::shm
