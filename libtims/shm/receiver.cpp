// The seldom used part of the receiver, for lost hints and for cleaning up.
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

Receiver::Receiver(const MailboxView& view)
    : view_(view), index_(view.geometry().ring), free_tail_(view.geometry().slots) {}

void Receiver::put_back(const Taken& taken) {
  const SlotWord word = taken.hint.readable();
  make_room();
  index_.put_back(taken.hint);
  Word64& received = view_.header().received;
  received.store(received.load(memory_order_relaxed) - 1, memory_order_relaxed);
  view_.slot(taken.hint.index).word.store(word.pack(), memory_order_release);
}

std::size_t Receiver::clean() {
  std::size_t thrown = 0;
  ingest();
  while (!index_.empty()) {
    const auto taken = take_front();
    if (!taken) continue;
    release(taken->hint);
    ++thrown;
  }
  return thrown;
}

// Hints of replaced messages accumulate while more important messages keep the owner busy. Only one
// valid hint remains for each slot, so there is room for as many as there are slots.
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
  return view_.slot(hint.index).word.load(memory_order_acquire) == hint.readable().pack();
}

// Hints were lost: rebuilds the order from the slots themselves.
//
// A message with a stamp not after `now` was announced before this scan began, and so was every
// message sent before it: order is preserved. Messages with a later stamp are left for the next
// scan: their hints are behind the tail, or the rescan counter has advanced since.
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

// The tail is read before the counter: no hint before the tail has a later stamp than the result.
Stamp Receiver::stamp_at(std::uint64_t tail) const {
  return {static_cast<std::uint32_t>(tail),
          static_cast<std::uint32_t>(view_.header().rescans.load(memory_order_acquire))};
}

// A stamp from the future is invalid, but must not block its message for ever.
bool Receiver::is_possible(Stamp stamp) const {
  return stamp.not_after(stamp_at(view_.header().arrival_tail.load(memory_order_acquire)));
}

void Receiver::collect_abandoned(std::uint32_t index, SlotWord word) {
  if (view_.slot(index).word.compare_exchange(word.pack(), word.freed().pack(),
                                              memory_order_acq_rel))
    push_free({.generation = word.generation, .index = static_cast<std::uint16_t>(index)});
}

std::uint64_t waiting(const MailboxView& view) {
  std::uint64_t count = 0;
  for (std::uint32_t i = 0; i < view.geometry().slots; ++i) {
    const SlotWord word = SlotWord::unpack(view.slot(i).word.load(memory_order_relaxed));
    count += word.state == SlotState::kReadable ? 1 : 0;
  }
  return count;
}

Counters& Counters::operator+=(const Counters& more) {
  received += more.received;
  replaced += more.replaced;
  refused += more.refused;
  too_big += more.too_big;
  reclaimed += more.reclaimed;
  return *this;
}

Counters counters(const MailboxView& view) {
  const MailboxHeader& header = view.header();
  const auto read = [](const Word64& word) { return word.load(memory_order_relaxed); };
  return {.received = read(header.received),
          .replaced = read(header.replaced),
          .refused = read(header.refused),
          .too_big = read(header.too_big),
          .reclaimed = read(header.reclaimed)};
}

}  // namespace tims::shm
