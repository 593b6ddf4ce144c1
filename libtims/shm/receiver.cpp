// The owner keeps its order in private memory (PriorityIndex) and checks every hint against the
// slot's word when it takes the message: a message that was replaced meanwhile is passed over.
#include "shm/receiver.h"

#include <algorithm>
#include <vector>

#include "wire/header.h"

namespace tims::shm {

using std::memory_order_acq_rel;
using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;

namespace {

SlotWord readable(Hint hint) { return {SlotState::kReadable, hint.priority, 0, hint.generation}; }

}  // namespace

Receiver::Receiver(const MailboxView& view)
    : view_(view), index_(view.geometry().ring), free_tail_(view.geometry().slots) {}

std::optional<Taken> Receiver::take() {
  ingest();
  return next();
}

std::optional<Taken> Receiver::next() {
  while (!index_.empty()) {
    const Hint hint = index_.front();
    index_.pop();
    if (!index_.empty()) view_.prefetch(index_.front().index);
    const SlotWord word = readable(hint);
    if (!view_.slot(hint.index)
             .word.compare_exchange(word.pack(), word.locked().pack(), memory_order_acq_rel))
      continue;
    const std::byte* message = view_.message(hint.index);
    const Header header = wire::decode_header(wire::ConstHeaderBytes(message, kHeaderSize));
    // The sender wrote the length: it is checked before anybody follows it.
    const bool fits = header.length >= kHeaderSize && header.length <= view_.geometry().message_max;
    if (fits) {
      Word64& received = view_.header().received;
      received.store(received.load(memory_order_relaxed) + 1, memory_order_relaxed);
      return Taken{hint, header, {message + kHeaderSize, header.body_size()}};
    }
    view_.header().reclaimed.fetch_add(1, memory_order_relaxed);
    release(hint);
  }
  return std::nullopt;
}

void Receiver::put_back(const Taken& taken) {
  const SlotWord word = readable(taken.hint);
  make_room();
  index_.put_back(taken.hint);
  Word64& received = view_.header().received;
  received.store(received.load(memory_order_relaxed) - 1, memory_order_relaxed);
  view_.slot(taken.hint.index).word.store(word.pack(), memory_order_release);
}

void Receiver::release(Hint hint) {
  const SlotWord word{.generation = hint.generation};
  view_.slot(hint.index).word.store(word.pack(), memory_order_release);
  push_free(hint);
}

// The free ring only hints: when it has no room, the slot is found by looking at every slot.
void Receiver::push_free(Hint hint) {
  constexpr std::uint32_t kMargin = kRingSpare / 2;  // threads that may be past the check at once
  const Geometry& geometry = view_.geometry();
  const std::uint64_t limit = geometry.ring - kMargin;
  if (free_tail_.load(memory_order_relaxed) - free_head_seen_.load(memory_order_relaxed) >= limit) {
    const std::uint64_t head = view_.header().free_head.load(memory_order_acquire);
    free_head_seen_.store(head, memory_order_relaxed);
    if (free_tail_.load(memory_order_relaxed) - head >= limit) return;
  }
  const std::uint64_t position = free_tail_.fetch_add(1, memory_order_relaxed);
  hint.lap = geometry.lap_of(position);
  hint.priority = 0;
  view_.free(position).store(hint.pack(), memory_order_release);
}

std::size_t Receiver::clean() {
  std::size_t thrown = 0;
  ingest();
  while (const std::optional<Taken> taken = next()) {
    release(taken->hint);
    ++thrown;
  }
  return thrown;
}

// Moves hints from the shared ring into the private order. Whether hints are missing is asked once
// more afterwards: one that is here may have come after one that is not.
void Receiver::ingest() {
  const Word64& rescans = view_.header().rescans;
  if (rescans.load(memory_order_acquire) == rescans_seen_) drain_ring();
  if (rescans.load(memory_order_acquire) != rescans_seen_) rescan();
}

// At most one lap.
void Receiver::drain_ring() {
  const Geometry& geometry = view_.geometry();
  const std::uint64_t before = arrival_head_;
  for (std::uint32_t n = 0; n < geometry.ring; ++n) {
    const Hint hint = Hint::unpack(view_.arrival(arrival_head_).load(memory_order_acquire));
    if (hint.lap != geometry.lap_of(arrival_head_)) break;
    ++arrival_head_;
    if (hint.index >= geometry.slots) continue;
    make_room();
    index_.put(hint);
  }
  if (arrival_head_ != before)
    view_.header().arrival_head.store(arrival_head_, memory_order_release);
}

// Hints of messages that were replaced pile up while more important ones keep the owner busy. One
// for each slot stays, so there is room for as many as there are slots.
void Receiver::make_room() {
  if (!index_.full()) return;
  std::vector<bool> kept(view_.geometry().slots);
  index_.retain([this, &kept](Hint hint) {
    if (kept[hint.index] || !still_waiting(hint)) return false;
    kept[hint.index] = true;
    return true;
  });
}

bool Receiver::still_waiting(Hint hint) const {
  return view_.slot(hint.index).word.load(memory_order_acquire) == readable(hint).pack();
}

// Hints were lost: builds the order anew from the slots themselves.
//
// A message stamped not after `now` was announced before this look at the slots began, and so was
// everything sent before it: nothing is overtaken. Messages stamped later stay for the next time:
// their hints come behind the tail, or the counter has moved on from what is remembered.
void Receiver::rescan() {
  MailboxHeader& header = view_.header();
  rescans_seen_ = header.rescans.load(memory_order_acquire);
  const std::uint64_t tail = header.arrival_tail.load(memory_order_acquire);
  const Stamp now = stamp_at(tail);
  std::vector<std::pair<std::uint64_t, Hint>> found;  // with its age
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    const SlotHeader& slot = view_.slot(i);
    const SlotWord word = SlotWord::unpack(slot.word.load(memory_order_acquire));
    if (word.state == SlotState::kAbandoned) collect_abandoned(i, word);
    if (word.state != SlotState::kReadable) continue;
    const Stamp stamp = Stamp::unpack(slot.stamp.load(memory_order_relaxed));
    if (!stamp.not_after(now) && is_possible(stamp)) continue;
    found.push_back({stamp.age(now),
                     {.generation = word.generation,
                      .priority = word.priority,
                      .index = static_cast<std::uint16_t>(i)}});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  index_.clear();
  for (const auto& [age, hint] : found) index_.put(hint);
  // A tail outside one lap was not written by an honest sender.
  if (tail - arrival_head_ <= view_.geometry().ring) arrival_head_ = tail;
  header.arrival_head.store(arrival_head_, memory_order_release);
}

// The tail was read before the counter is: no hint in front of it has a stamp after this one.
Stamp Receiver::stamp_at(std::uint64_t tail) const {
  return {static_cast<std::uint32_t>(tail),
          static_cast<std::uint32_t>(view_.header().rescans.load(memory_order_acquire))};
}

// A stamp from the future is nonsense, and no reason to keep its message for ever.
bool Receiver::is_possible(Stamp stamp) const {
  return stamp.not_after(stamp_at(view_.header().arrival_tail.load(memory_order_acquire)));
}

void Receiver::collect_abandoned(std::uint32_t index, SlotWord word) {
  if (view_.slot(index).word.compare_exchange(word.pack(), word.freed().pack(),
                                              memory_order_acq_rel))
    push_free({.generation = word.generation, .index = static_cast<std::uint16_t>(index)});
}

std::uint32_t Receiver::arm() {
  sleeps_ += 2;
  const std::uint32_t armed = sleeps_ | 1;
  view_.header().sleep.store(armed, memory_order_seq_cst);
  return armed;
}

void Receiver::disarm() { view_.header().sleep.store(sleeps_, memory_order_relaxed); }

bool Receiver::nothing_came() const {
  const Hint next = Hint::unpack(view_.arrival(arrival_head_).load(memory_order_seq_cst));
  return next.lap != view_.geometry().lap_of(arrival_head_) &&
         view_.header().rescans.load(memory_order_seq_cst) == rescans_seen_ && !closed();
}

std::uint64_t waiting(const MailboxView& view) {
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < view.geometry().slots; ++i) {
    const SlotWord word = SlotWord::unpack(view.slot(i).word.load(memory_order_relaxed));
    count += word.state == SlotState::kReadable ? 1 : 0;
  }
  return count;
}

}  // namespace tims::shm
