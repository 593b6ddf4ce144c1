// What a sender does when there is no hint to go by.
#include "shm/sender.h"

#include <cstring>

namespace tims::shm {

using std::memory_order_acq_rel;
using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;

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

// For a long body. The first place that is free: its pages are most likely to be there.
bool Sender::claim_place(Claim& claim) {
  const auto place = place_for(claim);
  if (!place) {
    give_up(claim);
    view_.header().refused.fetch_add(1, memory_order_relaxed);
    return false;
  }
  std::memcpy(claim.body, &*place, sizeof *place);
  claim.body = view_.long_body(*place);
  return true;
}

// A shared place is held by one life of a slot: it is free when that has ended, however it did.
std::optional<std::uint32_t> Sender::place_for(const Claim& claim) {
  const Geometry& geometry = view_.geometry();
  if (!geometry.shares_places()) return claim.index;
  const Hint mine{.generation = claim.word.generation,
                  .index = static_cast<std::uint16_t>(claim.index)};
  for (std::uint32_t place = 0; place < geometry.long_places; ++place) {
    Word64& holder = view_.holder(place);
    const std::uint64_t packed = holder.load(memory_order_acquire);
    const Hint before = Hint::unpack(packed);
    if (before.index >= geometry.slots) continue;
    const SlotWord word =
        SlotWord::unpack(view_.slot(before.index).word.load(memory_order_acquire));
    const bool lives = word.generation == before.generation && word.state != SlotState::kFree;
    if (!lives && holder.compare_exchange(packed, mine.pack(), memory_order_acq_rel)) return place;
  }
  return std::nullopt;
}

void Sender::give_up(const Claim& claim) {
  if (view_.slot(claim.index)
          .word.compare_exchange(claim.word.pack(), claim.word.abandoned().pack(),
                                 memory_order_release))
    view_.header().rescans.fetch_add(1, memory_order_seq_cst);
}

}  // namespace tims::shm
