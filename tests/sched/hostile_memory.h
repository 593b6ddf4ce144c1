// A mailbox whose memory is corrupted on purpose, between two pages without access.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <new>
#include <random>
#include <span>
#include <vector>

#include <sys/mman.h>

#include "shm/layout.h"
#include "shm/slot.h"

namespace tims::shm {

// The mailbox ends at the second page without access.
class GuardedMailbox {
 public:
  GuardedMailbox(std::uint32_t slots, std::uint32_t message_max, std::uint32_t long_places = 0)
      : geometry_(Geometry::of(slots, message_max, long_places)),
        inside_((geometry_.bytes + kPage - 1) / kPage * kPage),
        map_(static_cast<std::byte*>(
            ::mmap(nullptr, inside_ + 2 * kPage, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    if (map_ == MAP_FAILED || ::mprotect(map_ + kPage, inside_, PROT_READ | PROT_WRITE) != 0)
      throw std::bad_alloc();
    lay_out();
  }
  ~GuardedMailbox() { ::munmap(map_, inside_ + 2 * kPage); }
  GuardedMailbox(const GuardedMailbox&) = delete;
  GuardedMailbox& operator=(const GuardedMailbox&) = delete;

  // Creates the mailbox again.
  MailboxView lay_out() {
    std::ranges::fill(segment(), std::byte{0});
    return MailboxView::create(segment(), offset(),
                               {.address = Address(1),
                                .slots = geometry_.slots,
                                .message_max = geometry_.message_max,
                                .long_places = geometry_.long_places});
  }
  [[nodiscard]] std::span<std::byte> segment() const { return {map_ + kPage, inside_}; }
  [[nodiscard]] std::uint64_t offset() const {
    return (inside_ - geometry_.bytes) / kMailboxAlign * kMailboxAlign;
  }
  [[nodiscard]] std::span<std::byte> mailbox() const { return segment().subspan(offset()); }
  [[nodiscard]] const Geometry& geometry() const { return geometry_; }

 private:
  static constexpr std::size_t kPage = 4096;

  Geometry geometry_;
  std::size_t inside_;
  std::byte* map_;
};

// Overwrites 64-bit fields with values that are likely to do harm: well-formed ones, values close
// to the present one, earlier ones, or random ones.
class Scribbler {
 public:
  Scribbler(const GuardedMailbox& mailbox, std::uint32_t seed)
      : words_(reinterpret_cast<Word*>(mailbox.mailbox().data()),
               mailbox.mailbox().size() / sizeof(Word)),
        geometry_(mailbox.geometry()),
        random_(seed) {
    for (const Word& word : words_) sound_.push_back(word.load(std::memory_order_relaxed));
  }

  void scribble() {
    const std::size_t place = choose_place() % words_.size();
    const std::uint64_t before = words_[place].load(std::memory_order_relaxed);
    words_[place].store(choose_value(place, before), std::memory_order_relaxed);
    history_[any() % history_.size()] = before;
    // A closed mailbox is not used any more, so the flag is overwritten often enough to be open.
    if (any() % 4 == 0) words_[kSleepAndClosed].store(any(), std::memory_order_relaxed);
  }

 private:
  using Word = std::atomic<std::uint64_t>;
  static constexpr std::size_t kSleepAndClosed = offsetof(MailboxHeader, sleep) / sizeof(Word);

  std::uint32_t any() { return static_cast<std::uint32_t>(random_()); }

  // Half of the time the header: it is small, and every operation begins there.
  std::size_t choose_place() {
    if (any() % 2 == 0) return any() % (sizeof(MailboxHeader) / sizeof(Word));
    return any();
  }
  std::uint64_t choose_value(std::size_t place, std::uint64_t before) {
    const std::uint64_t anything = std::uint64_t{any()} << 32 | any();
    switch (any() % 12) {
      case 0:
        return anything;
      case 1:
        return before + any() % 3 - 1;
      case 2:
        return before ^ std::uint64_t{1} << any() % 64;
      case 3:
        return history_[any() % history_.size()];
      case 4:
        return any() % 2 == 0 ? 0 : ~std::uint64_t{0};
      case 5:
        return before + geometry_.ring;
      case 6:
        return hint(before);
      case 7:
        return slot_word(before);
      default:
        return sound_[place];
    }
  }
  // A hint of the present lap or the next, to a slot that may not exist.
  std::uint64_t hint(std::uint64_t before) {
    Hint hint = Hint::unpack(before);
    hint.lap = static_cast<std::uint16_t>(hint.lap + any() % 2);
    hint.index = static_cast<std::uint16_t>(any() % 3 == 0 ? any() : any() % geometry_.slots);
    hint.generation = any() % 4;
    return hint.pack();
  }
  std::uint64_t slot_word(std::uint64_t before) {
    SlotWord word = SlotWord::unpack(before);
    word.state = static_cast<SlotState>(any() % 6);
    word.generation += any() % 2;
    return word.pack();
  }

  std::span<Word> words_;
  std::vector<std::uint64_t> sound_;  // contents of the newly created mailbox
  Geometry geometry_;
  std::mt19937 random_;
  std::array<std::uint64_t, 64> history_{};
};

}  // namespace tims::shm
