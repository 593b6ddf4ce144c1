// Rules that keep this safe against death at any step and against other senders:
//  - A slot changes hands only by compare-and-swap on its word, which names the writer.
//  - Rings are moved by helping: whoever finds an entry that was already used moves the position
//    on, so nobody waits for a sender that was stopped in between.
//  - Every loop is bounded by the size of the mailbox, whatever the memory says.
#include "shm/sender.h"

#include <optional>

namespace tims::shm {

using std::memory_order_acq_rel;
using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;

SendOutcome Sender::claim(std::uint32_t length, std::uint8_t priority, Claim& claim) {
  if (closed()) return SendOutcome::kClosed;
  if (length > view_.geometry().message_max) {
    view_.header().too_big.fetch_add(1, memory_order_relaxed);
    return SendOutcome::kTooBig;
  }
  if (claim_free(priority, claim)) return SendOutcome::kOk;
  return claim_by_scan(priority, claim);
}

bool Sender::claim_free(std::uint8_t priority, Claim& claim) {
  const Geometry& geometry = view_.geometry();
  Word64& head = view_.header().free_head;
  for (std::uint32_t tries = 0; tries < 2 * geometry.ring; ++tries) {
    const std::uint64_t position = head.load(memory_order_acquire);
    const Hint hint = Hint::unpack(view_.free(position).load(memory_order_acquire));
    if (hint.lap != geometry.lap_of(position)) {
      if (head.load(memory_order_acquire) == position) return false;  // nothing free
      continue;                                                       // a late look
    }
    const bool mine = hint.index < geometry.slots &&
                      claim_slot(hint.index, {.generation = hint.generation}, priority, claim);
    head.compare_exchange(position, position + 1, memory_order_acq_rel);
    if (!mine) continue;
    // The slot after next is on its way into this processor's cache meanwhile.
    const Hint next = Hint::unpack(view_.free(position + 2).load(memory_order_relaxed));
    if (next.index < geometry.slots) view_.prefetch(next.index);
    return true;
  }
  return false;
}

bool Sender::claim_slot(std::uint32_t index, SlotWord from, std::uint8_t priority, Claim& claim) {
  const SlotWord to = from.claimed_by(writer_, priority);
  if (!view_.slot(index).word.compare_exchange(from.pack(), to.pack(), memory_order_acq_rel))
    return false;
  claim = {index, to, view_.message(index)};
  return true;
}

// No hint: look at every slot, until one is claimed or two looks have seen the same: words do not
// come back, so at the moment between the two the mailbox was full. The bound is for hostile
// memory.
SendOutcome Sender::claim_by_scan(std::uint8_t priority, Claim& claim) {
  constexpr int kLooksMax = 32;
  std::optional<std::uint64_t> seen;
  for (int looks = 0; looks < kLooksMax; ++looks) {
    const Room room = find_room(priority);
    if (!room.found && seen == room.fingerprint) break;
    seen = room.fingerprint;
    if (!room.found || !claim_slot(room.index, room.word, priority, claim)) continue;
    if (room.word.state != SlotState::kReadable) return SendOutcome::kOk;
    view_.header().replaced.fetch_add(1, memory_order_relaxed);
    return SendOutcome::kReplaced;
  }
  view_.header().refused.fetch_add(1, memory_order_relaxed);
  return SendOutcome::kFull;
}

// A free slot, else that of the oldest message of the lowest priority waiting, if that is not above
// `priority`.
Sender::Room Sender::find_room(std::uint8_t priority) const {
  constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15;
  const Stamp present = now();
  Room room;
  std::uint64_t oldest = 0;
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    const SlotHeader& slot = view_.slot(i);
    const std::uint64_t packed = slot.word.load(memory_order_acquire);
    room.fingerprint = (room.fingerprint ^ packed) * kOdd;
    const SlotWord word = SlotWord::unpack(packed);
    if (word.state == SlotState::kFree || word.state == SlotState::kAbandoned)
      return {true, i, word, 0};
    // What waits in an uplink has receivers of its own: its sender waits for room instead.
    if (view_.wake() == WakeKind::kDoorbell) continue;
    if (word.state != SlotState::kReadable || word.priority > priority) continue;
    const std::uint64_t age = Stamp::unpack(slot.stamp.load(memory_order_relaxed)).age(present);
    if (room.found && (word.priority > room.word.priority ||
                       (word.priority == room.word.priority && age <= oldest)))
      continue;
    room = {true, i, word, room.fingerprint};
    oldest = age;
  }
  return room;
}

Stamp Sender::now() const {
  const MailboxHeader& header = view_.header();
  return {static_cast<std::uint32_t>(header.arrival_tail.load(memory_order_acquire)),
          static_cast<std::uint32_t>(header.rescans.load(memory_order_acquire))};
}

SendOutcome Sender::commit(const Claim& claim) {
  SlotHeader& slot = view_.slot(claim.index);
  slot.stamp.store(now().pack(), memory_order_relaxed);
  if (!slot.word.compare_exchange(claim.word.pack(), claim.word.committed().pack(),
                                  memory_order_release))
    return SendOutcome::kReclaimed;
  announce(claim);
  return SendOutcome::kOk;
}

// Puts a hint into the arrival ring; when there is no room, asks the owner to look at every slot.
// Sequentially consistent: either the owner sees it before it sleeps, or sleeper() sees it asleep.
void Sender::announce(const Claim& claim) {
  const Geometry& geometry = view_.geometry();
  Word64& tail = view_.header().arrival_tail;
  for (std::uint32_t tries = 0; tries < 2 * geometry.ring; ++tries) {
    const std::uint64_t position = tail.load(memory_order_acquire);
    if (ring_full(position)) break;
    const std::uint16_t lap = geometry.lap_of(position);
    Word64& cell = view_.arrival(position);
    const std::uint64_t before = cell.load(memory_order_acquire);
    const std::uint16_t lap_before = Hint::unpack(before).lap;
    if (lap_before == lap) {  // its sender has not moved the tail yet, or never will
      tail.compare_exchange(position, position + 1, memory_order_acq_rel);
      continue;
    }
    if (lap_before != static_cast<std::uint16_t>(lap - 1)) {
      if (tail.load(memory_order_acquire) == position) break;  // nonsense: do without the ring
      continue;                                                // a late look at the tail
    }
    const Hint hint{lap, claim.word.generation, claim.word.priority,
                    static_cast<std::uint16_t>(claim.index)};
    if (!cell.compare_exchange(before, hint.pack(), memory_order_seq_cst)) continue;
    tail.compare_exchange(position, position + 1, memory_order_acq_rel);
    return;
  }
  view_.header().rescans.fetch_add(1, memory_order_seq_cst);
}

// The head may be in front of the tail: the owner takes a hint before its sender has moved the
// tail.
bool Sender::ring_full(std::uint64_t position) {
  const auto full_at = [this, position](std::uint64_t head) {
    return static_cast<std::int64_t>(position - head) >= view_.geometry().ring;
  };
  if (!full_at(arrival_head_seen_.load(memory_order_acquire))) return false;
  const std::uint64_t head = view_.header().arrival_head.load(memory_order_acquire);
  arrival_head_seen_.store(head, memory_order_release);
  return full_at(head);
}

void Sender::give_up(const Claim& claim) {
  if (view_.slot(claim.index)
          .word.compare_exchange(claim.word.pack(), claim.word.abandoned().pack(),
                                 memory_order_release))
    view_.header().rescans.fetch_add(1, memory_order_seq_cst);
}

}  // namespace tims::shm
