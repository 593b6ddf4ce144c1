// The simplest transfer of messages between processes on a host: a ring in shared memory with one
// writer, up to eight readers that all receive every message, one copy, and futex waits. Without
// priorities, replacement, a second writer, or checks. It is the limit for mailboxes.
//
// Streams use its fastest mode: the writer publishes several messages at once, and reader and
// writer poll before they sleep.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "libtims/os/clock.h"
#include "tests/bench/shared_file.h"
#include "tims/result.h"

namespace tims::bench {

class SharedRing {
 public:
  struct Shape {
    std::size_t message_max = 0;
    std::uint64_t slots = 1;
    std::uint32_t readers = 1;
    std::uint64_t gather = 1;  // messages published at once
    Duration spin{};           // before sleeping
  };
  static constexpr std::uint32_t kReadersMax = 8;

  // All processes must use the same shape. The first one creates the file.
  static Result<SharedRing> open(const std::string& path, const Shape& shape);

  // Copies the first `copied` bytes. Waits for room up to two seconds.
  bool write(std::span<const std::byte> message, std::size_t copied);
  void publish();

  // Waits up to the timeout, then delivers all available messages, in place.
  template <typename Deliver>
  void read(std::uint32_t reader, Duration timeout, Deliver deliver) {
    std::atomic<std::uint64_t>& tail = ring_->tails[reader].count;
    std::uint64_t next = tail.load(std::memory_order_relaxed);
    const std::uint64_t head = wait_for_more(next, timeout);
    while (next != head) {
      const std::byte* slot = slot_at(next);
      std::uint64_t size = 0;
      std::memcpy(&size, slot, sizeof size);
      deliver(std::span(slot + kSizeBytes, static_cast<std::size_t>(size)));
      tail.store(++next, std::memory_order_release);
      if (next == head || next % wake_every_ == 0) wake_writer(head - next);
    }
  }

 private:
  static constexpr std::size_t kLine = 64;
  static constexpr std::size_t kSizeBytes = 8;

  struct Layout {
    struct alignas(kLine) Tail {
      std::atomic<std::uint64_t> count;
    };
    alignas(kLine) std::atomic<std::uint64_t> head;
    std::atomic<std::uint32_t> head_futex;  // a copy of the head, for the futex
    alignas(kLine) std::atomic<std::uint32_t> readers_asleep;
    alignas(kLine) std::atomic<std::uint32_t> room_futex;
    std::atomic<std::uint32_t> writer_asleep;
    Tail tails[kReadersMax];
  };

  SharedRing(SharedFile memory, const Shape& shape);
  static std::size_t slot_bytes(const Shape& shape);

  std::byte* slot_at(std::uint64_t position) const {
    return slots_ + position % shape_.slots * slot_bytes_;
  }
  std::uint64_t wait_for_more(std::uint64_t next, Duration timeout);
  [[nodiscard]] std::uint64_t slowest() const;
  bool wait_for_room();
  void wake_writer(std::uint64_t unread);

  SharedFile memory_;
  Layout* ring_;
  std::byte* slots_;
  Shape shape_;
  std::size_t slot_bytes_;
  std::uint64_t wake_every_;
  std::uint64_t head_ = 0;       // writer: messages written
  std::uint64_t published_ = 0;  // writer: messages published
  std::uint64_t low_ = 0;        // writer: messages read by all, as last loaded
};

}  // namespace tims::bench
