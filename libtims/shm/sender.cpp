// Functions of the sender for whole messages, and for claiming a slot without a hint.
#include "shm/sender.h"

#include <algorithm>
#include <cstring>
#include <functional>

namespace tims::shm {

using std::memory_order_acq_rel;
using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;

SendOutcome Sender::put(std::span<const std::byte, kHeaderSize> header,
                        std::span<const std::byte> body, std::uint8_t priority) {
  Claim slot;
  const auto length = static_cast<std::uint32_t>(kHeaderSize + body.size());
  const SendOutcome outcome = claim(length, priority, slot);
  if (!taken(outcome)) return outcome;
  // With std::ranges::copy (g++ 12), messages of 1 MiB between hosts were a third slower.
  std::memcpy(slot.header, header.data(), header.size());
  if (!body.empty()) std::memcpy(slot.body, body.data(), body.size());
  const SendOutcome committed = commit(slot);
  return committed == SendOutcome::kOk ? outcome : committed;
}

// Without a hint: scans all slots until one is claimed or two scans have seen the same state words.
// State words never repeat, so in the second case the mailbox was full at a moment between the two
// scans. The bound protects against hostile memory.
SendOutcome Sender::claim_by_scan(std::uint8_t priority, Claim& claim) {
  constexpr int kLooksMax = 32;
  if (const auto known = claim_remembered(priority, claim)) return *known;
  std::optional<std::uint64_t> seen;
  for (int looks = 0; looks < kLooksMax; ++looks) {
    const std::uint64_t tail = view_.header().arrival_tail.load(memory_order_acquire);
    const Stamp present = now();
    const Room room = find_room(priority, present);
    if (!room.found && seen == room.fingerprint) break;
    seen = room.fingerprint;
    if (!room.found || !claim_slot(room.index, room.word, priority, claim)) continue;
    if (room.word.state != SlotState::kReadable) return SendOutcome::kOk;
    view_.header().replaced.fetch_add(1, memory_order_relaxed);
    remember(room, present, tail);
    return SendOutcome::kReplaced;
  }
  view_.header().refused.fetch_add(1, memory_order_relaxed);
  return SendOutcome::kFull;
}

// Finds a free slot, else the slot of the oldest message of the lowest waiting priority, if that is
// not above `priority`.
Sender::Room Sender::find_room(std::uint8_t priority, Stamp present) const {
  constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15;
  Room room;
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    const SlotHeader& slot = view_.slot(i);
    const std::uint64_t packed = slot.word.load(memory_order_acquire);
    room.fingerprint = (room.fingerprint ^ packed) * kOdd;
    const SlotWord word = SlotWord::unpack(packed);
    if (word.state == SlotState::kFree || word.state == SlotState::kAbandoned)
      return {.found = true, .index = i, .word = word};
    // Messages in an uplink have different final receivers: the sender waits for room instead of
    // replacing them.
    if (view_.wake() == WakeKind::kDoorbell) continue;
    if (word.state != SlotState::kReadable || word.priority > priority) continue;
    const std::uint64_t age = Stamp::unpack(slot.stamp.load(memory_order_relaxed)).age(present);
    if (room.found && (word.priority > room.word.priority ||
                       (word.priority == room.word.priority && age <= room.age)))
      continue;
    room = {true, i, word, room.fingerprint, age};
  }
  return room;
}

// Remembers the messages of the same priority as the one in `room` that came next after it. `tail`:
// end of the arrival ring before the scan.
void Sender::remember(const Room& room, Stamp present, std::uint64_t tail) {
  if (next_to_go_.capacity() == 0 || !remembering_.compare_exchange(0, 1, memory_order_acquire))
    return;
  next_to_go_.clear();
  gone_ = 0;
  looked_up_to_ = tail;
  rescans_then_ = present.rescans;
  lowest_without_hint_.store(kNoPriority, memory_order_relaxed);
  without_hint_.store(0, memory_order_release);
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    const SlotHeader& slot = view_.slot(i);
    const SlotWord word = SlotWord::unpack(slot.word.load(memory_order_acquire));
    if (word.state != SlotState::kReadable || word.priority > room.word.priority) continue;
    const std::uint64_t age = Stamp::unpack(slot.stamp.load(memory_order_relaxed)).age(present);
    // it arrived after the scan of its slot
    const bool less_important = word.priority < room.word.priority;
    if (!less_important && (age > room.age || age + kRemembered <= room.age)) continue;
    // more than can be waiting at one time
    if (less_important || next_to_go_.size() == kRemembered) {
      next_to_go_.clear();
      break;
    }
    next_to_go_.push_back({i, word, age});
  }
  std::ranges::sort(next_to_go_, std::greater(), &NextToGo::age);
  remembering_.store(0, memory_order_release);
}

// Nothing: a new scan is needed. A message that was replaced, read or reclaimed since the scan has
// another state word; a message that arrived since the scan is younger and not less important.
std::optional<SendOutcome> Sender::claim_remembered(std::uint8_t priority, Claim& claim) {
  if (next_to_go_.capacity() == 0 || !remembering_.compare_exchange(0, 1, memory_order_acquire))
    return std::nullopt;
  std::optional<SendOutcome> outcome;
  const bool all_is_known = gone_ < next_to_go_.size() && nothing_less_important_came();
  while (all_is_known && !outcome && gone_ < next_to_go_.size()) {
    const NextToGo& next = next_to_go_[gone_];
    const bool is_there =
        view_.slot(next.index).word.load(memory_order_acquire) == next.word.pack();
    if (is_there && next.word.priority > priority) {
      outcome = SendOutcome::kFull;
      view_.header().refused.fetch_add(1, memory_order_relaxed);
      break;
    }
    ++gone_;
    if (!is_there || !claim_slot(next.index, next.word, priority, claim)) continue;
    outcome = SendOutcome::kReplaced;
    view_.header().replaced.fetch_add(1, memory_order_relaxed);
  }
  if (!all_is_known) next_to_go_.clear();
  remembering_.store(0, memory_order_release);
  return outcome;
}

// Checks the messages announced since the scan. If there are more than the remembered number, a new
// scan is not more expensive.
bool Sender::nothing_less_important_came() {
  const MailboxHeader& header = view_.header();
  const std::uint64_t tail = header.arrival_tail.load(memory_order_acquire);
  const auto rescans = static_cast<std::uint32_t>(header.rescans.load(memory_order_acquire));
  const std::uint8_t lowest = next_to_go_.front().word.priority;
  // Of the messages sent without a hint, only those of this sender are known.
  if (rescans - rescans_then_ != without_hint_.load(memory_order_acquire)) return false;
  if (lowest_without_hint_.load(memory_order_relaxed) < lowest) return false;
  if (tail - looked_up_to_ > kRemembered) return false;
  for (; looked_up_to_ != tail; ++looked_up_to_) {
    const Hint hint = Hint::unpack(view_.arrival(looked_up_to_).load(memory_order_acquire));
    if (hint.lap != view_.geometry().lap_of(looked_up_to_)) return false;
    if (hint.priority < lowest) return false;
  }
  return true;
}

// The priority is stored first: a thread that sees the message counted must see its priority too.
void Sender::count_without_hint(std::uint8_t priority) {
  std::uint32_t seen = lowest_without_hint_.load(memory_order_relaxed);
  while (priority < seen &&
         !lowest_without_hint_.compare_exchange(seen, priority, memory_order_relaxed))
    seen = lowest_without_hint_.load(memory_order_relaxed);
  without_hint_.fetch_add(1, memory_order_release);
}

// Claims a place for a long body. The first free place is preferred: its pages are most likely to
// be allocated.
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

// A shared place is held by one generation of a slot: it is free when that generation has ended,
// for whatever reason.
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
