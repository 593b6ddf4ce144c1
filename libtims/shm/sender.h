// The sending side of a mailbox: claim a slot, write the message into it, commit. Lock-free, for
// any number of threads and processes; never waits. The caller must wake a sleeping owner.
//
// Rules that make this safe against a crash at any step and against other senders:
//  - A slot changes its owner only by compare-and-swap on its state word, which names the writer.
//  - Rings are advanced by helping: a thread that finds an entry already used advances the
//    position, so no thread waits for a sender that was stopped in between.
//  - Every loop is bounded by the size of the mailbox, whatever the memory contains.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shm/layout.h"
#include "shm/slot.h"

namespace tims::shm {

enum class SendOutcome : std::uint8_t {
  kOk,
  kReplaced,   // claimed; an older message was dropped for it
  kFull,       // only more important messages, or slots that are being written or read
  kTooBig,     // larger than a slot
  kClosed,     // the mailbox is gone; look the address up again
  kReclaimed,  // the router had declared this writer dead and reclaimed the slot
};
constexpr bool taken(SendOutcome o) { return o == SendOutcome::kOk || o == SendOutcome::kReplaced; }

// A slot that belongs to one sender until it commits or gives up.
struct Claim {
  std::uint32_t index = 0;
  SlotWord word;
  std::byte* header = nullptr;  // of the message: kHeaderSize bytes
  std::byte* body = nullptr;    // as many bytes as were claimed
};

class Sender {
 public:
  // `writer`: the identity that the router assigned to this process, 1 to 0xFFFFFF.
  Sender(const MailboxView& view, std::uint32_t writer) : view_(view), writer_(writer) {
    if (view_.geometry().slots >= kManySlots) next_to_go_.reserve(kRemembered);
  }

  // `length`: of the whole message, at least kHeaderSize. kOk or kReplaced: `claim` is set.
  SendOutcome claim(std::uint32_t length, std::uint8_t priority, Claim& claim);
  // Makes the message visible. kOk or kReclaimed.
  SendOutcome commit(const Claim& claim);
  void give_up(const Claim& claim);
  // Claims, copies and commits a message from other memory. kOk and kReplaced: the message was
  // delivered.
  SendOutcome put(std::span<const std::byte, kHeaderSize> header, std::span<const std::byte> body,
                  std::uint8_t priority);

  // After commit: the value of MailboxHeader::sleep if the owner must be woken, else 0.
  [[nodiscard]] std::uint32_t sleeper() const {
    const std::uint32_t sleep = view_.header().sleep.load(std::memory_order_seq_cst);
    return (sleep & 1) != 0 ? sleep : 0;
  }
  [[nodiscard]] bool closed() const {
    return view_.header().closed.load(std::memory_order_acquire) != 0;
  }
  [[nodiscard]] const MailboxView& view() const { return view_; }

 private:
  bool claim_free(std::uint8_t priority, Claim& claim);
  SendOutcome claim_by_scan(std::uint8_t priority, Claim& claim);
  bool claim_place(Claim& claim);
  std::optional<std::uint32_t> place_for(const Claim& claim);
  bool claim_slot(std::uint32_t index, SlotWord from, std::uint8_t priority, Claim& claim);
  // Result of one scan over all slots.
  struct Room {
    bool found = false;
    std::uint32_t index = 0;
    SlotWord word;
    std::uint64_t fingerprint = 0;  // of all state words
    std::uint64_t age = 0;          // of the message there
  };
  [[nodiscard]] Room find_room(std::uint8_t priority, Stamp present) const;

  // In a full mailbox of many slots, one scan finds the slots to replace for many following
  // messages.
  static constexpr std::uint32_t kRemembered = 256;
  static constexpr std::uint32_t kNoPriority = 256;
  static constexpr std::uint32_t kManySlots = 4 * kRemembered;
  struct NextToGo {
    std::uint32_t index = 0;
    SlotWord word;
    std::uint64_t age = 0;
  };
  void remember(const Room& room, Stamp present, std::uint64_t tail);
  std::optional<SendOutcome> claim_remembered(std::uint8_t priority, Claim& claim);
  bool nothing_less_important_came();
  void count_without_hint(std::uint8_t priority);
  [[nodiscard]] Stamp now() const;
  void announce(const Claim& claim);
  void raise_highest(std::uint8_t priority);
  bool ring_full(std::uint64_t position);

  MailboxView view_;
  std::uint32_t writer_;
  // The owner's head when last read: saves an access to the owner's cache line.
  Word64 arrival_head_seen_{0};

  Word32 remembering_{0};             // 1: a thread uses the members below
  std::vector<NextToGo> next_to_go_;  // messages of the lowest priority, the oldest first
  std::size_t gone_ = 0;              // how many of them were used
  std::uint64_t looked_up_to_ = 0;    // position in the arrival ring
  std::uint32_t rescans_then_ = 0;
  // Messages from this sender that were sent without a hint since the scan, and their lowest
  // priority.
  Word32 without_hint_{0};
  Word32 lowest_without_hint_{kNoPriority};
};

// --- hot path; seldom used functions are in sender.cpp ---

inline SendOutcome Sender::claim(std::uint32_t length, std::uint8_t priority, Claim& claim) {
  if (closed()) return SendOutcome::kClosed;
  if (length > view_.geometry().message_max) {
    view_.header().too_big.fetch_add(1, std::memory_order_relaxed);
    return SendOutcome::kTooBig;
  }
  SendOutcome outcome = SendOutcome::kOk;
  if (!claim_free(priority, claim)) outcome = claim_by_scan(priority, claim);
  if (!taken(outcome)) return outcome;
  claim.header = view_.message_header(claim.index);
  claim.body = view_.short_body(claim.index);
  const bool is_short = length - kHeaderSize <= view_.geometry().short_max;
  return is_short || claim_place(claim) ? outcome : SendOutcome::kFull;
}

inline bool Sender::claim_free(std::uint8_t priority, Claim& claim) {
  const Geometry& geometry = view_.geometry();
  Word64& head = view_.header().free_head;
  for (std::uint32_t tries = 0; tries < 2 * geometry.ring; ++tries) {
    const std::uint64_t position = head.load(std::memory_order_acquire);
    const Hint hint = Hint::unpack(view_.free(position).load(std::memory_order_acquire));
    if (hint.lap != geometry.lap_of(position)) {
      if (head.load(std::memory_order_acquire) == position) return false;  // no free slot
      continue;                                                            // outdated position
    }
    const bool mine = hint.index < geometry.slots &&
                      claim_slot(hint.index, {.generation = hint.generation}, priority, claim);
    head.compare_exchange(position, position + 1, std::memory_order_acq_rel);
    if (!mine) continue;
    // Prefetches the slot of one of the next messages into the cache of this processor.
    constexpr std::uint64_t kPrefetchAhead = 6;
    const Hint next =
        Hint::unpack(view_.free(position + kPrefetchAhead).load(std::memory_order_relaxed));
    if (next.index < geometry.slots) view_.prefetch(next.index);
    return true;
  }
  return false;
}

inline bool Sender::claim_slot(std::uint32_t index, SlotWord from, std::uint8_t priority,
                               Claim& claim) {
  const SlotWord to = from.claimed_by(writer_, priority);
  if (!view_.slot(index).word.compare_exchange(from.pack(), to.pack(), std::memory_order_acq_rel))
    return false;
  claim = {.index = index, .word = to};
  return true;
}

inline Stamp Sender::now() const {
  const MailboxHeader& header = view_.header();
  return {static_cast<std::uint32_t>(header.arrival_tail.load(std::memory_order_acquire)),
          static_cast<std::uint32_t>(header.rescans.load(std::memory_order_acquire))};
}

inline SendOutcome Sender::commit(const Claim& claim) {
  SlotHeader& slot = view_.slot(claim.index);
  slot.stamp.store(now().pack(), std::memory_order_relaxed);
  if (!slot.word.compare_exchange(claim.word.pack(), claim.word.committed().pack(),
                                  std::memory_order_release))
    return SendOutcome::kReclaimed;
  announce(claim);
  raise_highest(claim.word.priority);
  return SendOutcome::kOk;
}

// Puts a hint into the arrival ring; if the ring is full, asks the owner to scan all slots.
// Sequentially consistent: either the owner sees the hint before it sleeps, or sleeper() sees that
// the owner sleeps.
inline void Sender::announce(const Claim& claim) {
  const Geometry& geometry = view_.geometry();
  Word64& tail = view_.header().arrival_tail;
  for (std::uint32_t tries = 0; tries < 2 * geometry.ring; ++tries) {
    const std::uint64_t position = tail.load(std::memory_order_acquire);
    if (ring_full(position)) break;
    const std::uint16_t lap = geometry.lap_of(position);
    Word64& cell = view_.arrival(position);
    const std::uint64_t before = cell.load(std::memory_order_acquire);
    const std::uint16_t lap_before = Hint::unpack(before).lap;
    if (lap_before == lap) {  // its sender has not advanced the tail yet, or never will
      tail.compare_exchange(position, position + 1, std::memory_order_acq_rel);
      continue;
    }
    if (lap_before != static_cast<std::uint16_t>(lap - 1)) {
      if (tail.load(std::memory_order_acquire) == position)
        // invalid content: do without the ring
        break;
      continue;  // outdated tail
    }
    const Hint hint{lap, claim.word.generation, claim.word.priority,
                    static_cast<std::uint16_t>(claim.index)};
    if (!cell.compare_exchange(before, hint.pack(), std::memory_order_seq_cst)) continue;
    tail.compare_exchange(position, position + 1, std::memory_order_acq_rel);
    return;
  }
  view_.header().rescans.fetch_add(1, std::memory_order_seq_cst);
  if (next_to_go_.capacity() != 0) count_without_hint(claim.word.priority);
}

// After announcing: either the owner sees the hint after it lowered the value, or this sender sees
// the lowered value.
inline void Sender::raise_highest(std::uint8_t priority) {
  constexpr int kTriesMax = 512;  // each honest sender raises it, and the owner lowers it once
  Word32& highest = view_.header().highest;
  for (int tries = 0; tries < kTriesMax; ++tries) {
    const std::uint32_t seen = highest.load(std::memory_order_seq_cst);
    if (seen >= priority) return;
    if (highest.compare_exchange(seen, priority, std::memory_order_seq_cst)) return;
  }
}

// The head may be ahead of the tail: the owner can take a hint before its sender has advanced the
// tail.
inline bool Sender::ring_full(std::uint64_t position) {
  const auto full_at = [this, position](std::uint64_t head) {
    return static_cast<std::int64_t>(position - head) >= view_.geometry().ring;
  };
  if (!full_at(arrival_head_seen_.load(std::memory_order_acquire))) return false;
  const std::uint64_t head = view_.header().arrival_head.load(std::memory_order_acquire);
  arrival_head_seen_.store(head, std::memory_order_release);
  return full_at(head);
}

}  // namespace tims::shm
