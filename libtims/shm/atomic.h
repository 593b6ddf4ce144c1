// The atomics of shared memory, behind one name: a test can put its own in their place, by naming
// its header in TIMS_ATOMIC_HEADER, and so run the interleavings of the very code that ships.
#pragma once

#include <atomic>
#include <cstdint>

#ifdef TIMS_ATOMIC_HEADER
#include TIMS_ATOMIC_HEADER
#else

namespace tims::shm {

template <typename T>
class Atomic {
 public:
  Atomic() = default;
  explicit Atomic(T value) : value_(value) {}

  T load(std::memory_order order) const { return value_.load(order); }
  void store(T value, std::memory_order order) { value_.store(value, order); }
  bool compare_exchange(T expected, T desired, std::memory_order order) {
    return value_.compare_exchange_strong(expected, desired, order, std::memory_order_relaxed);
  }
  T fetch_add(T n, std::memory_order order) { return value_.fetch_add(n, order); }
  // The futex word's address, for the system call.
  const std::atomic<T>* raw() const { return &value_; }

 private:
  static_assert(std::atomic<T>::is_always_lock_free, "shared between processes");
  std::atomic<T> value_;
};

}  // namespace tims::shm

#endif

namespace tims::shm {

using Word32 = Atomic<std::uint32_t>;
using Word64 = Atomic<std::uint64_t>;

}  // namespace tims::shm
