#include "tests/bench/shared_ring.h"

#include <cstring>
#include <utility>

#include "tests/bench/futex.h"
#include "tests/bench/link.h"

namespace tims::bench {

Result<SharedRing> SharedRing::open(const std::string& path, const Shape& shape) {
  const std::size_t bytes = sizeof(Layout) + slot_bytes(shape) * shape.slots;
  auto memory = map_shared_file(path, bytes);
  if (!memory) return memory.error();
  return SharedRing(std::move(*memory), shape);
}

SharedRing::SharedRing(SharedFile memory, const Shape& shape)
    : memory_(std::move(memory)),
      ring_(reinterpret_cast<Layout*>(memory_.get())),
      slots_(memory_.get() + sizeof(Layout)),
      shape_(shape),
      slot_bytes_(slot_bytes(shape)),
      wake_every_(std::max<std::uint64_t>(1, shape.slots / 4)) {}

bool SharedRing::write(std::span<const std::byte> message, std::size_t copied) {
  if (head_ - low_ == shape_.slots && !wait_for_room()) return false;
  std::byte* slot = slot_at(head_);
  const std::uint64_t size = message.size();
  std::memcpy(slot, &size, sizeof size);
  std::memcpy(slot + kSizeBytes, message.data(), copied);
  if (++head_ - published_ >= shape_.gather) publish();
  return true;
}

void SharedRing::publish() {
  if (published_ == head_) return;
  published_ = head_;
  ring_->head.store(head_, std::memory_order_release);
  ring_->head_futex.store(static_cast<std::uint32_t>(head_), std::memory_order_seq_cst);
  if (ring_->readers_asleep.load(std::memory_order_seq_cst) > 0) futex_wake(ring_->head_futex);
}

std::uint64_t SharedRing::slowest() const {
  std::uint64_t low = head_;
  for (std::uint32_t i = 0; i < shape_.readers; ++i)
    low = std::min(low, ring_->tails[i].count.load(std::memory_order_acquire));
  return low;
}

bool SharedRing::wait_for_room() {
  constexpr Duration kNap = std::chrono::milliseconds(100);
  publish();
  low_ = slowest();
  if (head_ - low_ < shape_.slots) return true;
  for (int naps = 0; naps < 20; ++naps) {
    const std::uint32_t seen = ring_->room_futex.load(std::memory_order_acquire);
    ring_->writer_asleep.store(1, std::memory_order_seq_cst);
    low_ = slowest();
    if (head_ - low_ < shape_.slots) return true;
    futex_wait(ring_->room_futex, seen, kNap);
  }
  return false;
}

// Not for every message, so that a woken writer finds room for many.
void SharedRing::wake_writer(std::uint64_t unread) {
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (unread > shape_.slots / 2) return;
  if (ring_->writer_asleep.load(std::memory_order_relaxed) == 0) return;
  if (ring_->writer_asleep.exchange(0, std::memory_order_seq_cst) == 0) return;
  ring_->room_futex.fetch_add(1, std::memory_order_seq_cst);
  futex_wake(ring_->room_futex);
}

std::uint64_t SharedRing::wait_for_more(std::uint64_t next, Duration timeout) {
  std::uint64_t head = ring_->head.load(std::memory_order_acquire);
  const auto look = [&] {
    head = ring_->head.load(std::memory_order_acquire);
    return head != next;
  };
  if (head == next) look_for(shape_.spin, look);
  if (head != next || timeout <= Duration::zero()) return head;
  ring_->readers_asleep.fetch_add(1, std::memory_order_seq_cst);
  const std::uint32_t seen = ring_->head_futex.load(std::memory_order_seq_cst);
  if (seen == static_cast<std::uint32_t>(next)) futex_wait(ring_->head_futex, seen, timeout);
  ring_->readers_asleep.fetch_sub(1, std::memory_order_seq_cst);
  return ring_->head.load(std::memory_order_acquire);
}

std::size_t SharedRing::slot_bytes(const Shape& shape) {
  return (shape.message_max + kSizeBytes + kLine - 1) / kLine * kLine;
}

}  // namespace tims::bench
