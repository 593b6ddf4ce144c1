// Replaces the Atomic of libtims/shm/layout.h in the scheduled build: the same operations, each a
// step of the scheduler, on the machine's memory or on simulated weak memory.
#pragma once

#include <atomic>

#include "tests/sched/step.h"
#include "tests/sched/weak_memory.h"

namespace tims::shm {

template <typename T>
class Atomic {
 public:
  Atomic() = default;
  explicit Atomic(T value) : value_(value) {}

  T load(std::memory_order order) const {
    sched::step({this, sched::Access::kRead});
    if (const auto [memory, thread] = sched::weak_step(); memory != nullptr)
      return static_cast<T>(memory->load(thread, this, newest(), order));
    return value_.load(order);
  }
  void store(T value, std::memory_order order) {
    sched::step({this, sched::Access::kWrite});
    if (const auto [memory, thread] = sched::weak_step(); memory != nullptr)
      memory->store(thread, this, newest(), value, order);
    value_.store(value, order);
  }
  bool compare_exchange(T expected, T desired, std::memory_order order) {
    sched::step({this, sched::Access::kWrite, false, &is, expected});
    if (const auto [memory, thread] = sched::weak_step();
        memory != nullptr &&
        !memory->compare_exchange(thread, this, newest(), expected, desired, order))
      return false;
    return value_.compare_exchange_strong(expected, desired, order, std::memory_order_relaxed);
  }
  T fetch_add(T n, std::memory_order order) {
    return update([n](T before) { return static_cast<T>(before + n); }, order);
  }
  // For the kernel's operations on a futex.
  T fetch_and(T mask, std::memory_order order) {
    return update([mask](T before) { return static_cast<T>(before & mask); }, order);
  }
  const std::atomic<T>* raw() const { return &value_; }

 private:
  // Atomic, because in a schedule one thread runs at a time, and outside there is only one.
  template <typename F>
  T update(F f, std::memory_order order) {
    sched::step({this, sched::Access::kWrite});
    const T before = newest();
    if (const auto [memory, thread] = sched::weak_step(); memory != nullptr)
      memory->update(thread, this, before, f(before), order);
    value_.store(f(before), std::memory_order_relaxed);
    return before;
  }
  T newest() const { return value_.load(std::memory_order_relaxed); }
  static bool is(const void* atomic, std::uint64_t expected) {
    return static_cast<const Atomic*>(atomic)->newest() == expected;
  }

  std::atomic<T> value_;
};

}  // namespace tims::shm
