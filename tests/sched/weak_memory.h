// Memory as the C++ memory model allows it: a load may return an older value than the newest,
// unless a newer store happens before it.
//
// Every location keeps all its stores in the order in which they were made. A thread's view
// contains the oldest store of each location that the thread may still read; an acquiring load
// merges the view that was released with the store it reads. One of the permitted stores is chosen
// at random. Not simulated: stores that take effect in another order than they were made, and loads
// that see a later store.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/sched/scheduler.h"

namespace tims::sched {

class WeakMemory {
 public:
  // Starts a new run; every thread sees all earlier stores.
  void reset(std::uint32_t seed);
  void learn_everything(int thread);

  // `newest`: the value in memory; at the first access to a location it becomes its first store.
  std::uint64_t load(int thread, const void* where, std::uint64_t newest, std::memory_order order);
  void store(int thread, const void* where, std::uint64_t newest, std::uint64_t value,
             std::memory_order order);
  void update(int thread, const void* where, std::uint64_t newest, std::uint64_t value,
              std::memory_order order);
  bool compare_exchange(int thread, const void* where, std::uint64_t newest, std::uint64_t expected,
                        std::uint64_t desired, std::memory_order order);

  // Bytes that are not atomic: a write must happen after all earlier accesses, a read after the
  // last write; otherwise raced() becomes true.
  void read_bytes(int thread, const void* where);
  void write_bytes(int thread, const void* where);
  [[nodiscard]] bool raced() const { return raced_; }

 private:
  static constexpr std::size_t kLocationsMax = 128;
  using View = std::array<std::uint16_t, kLocationsMax>;  // the index of a store, by location
  struct Store {
    std::uint64_t value = 0;
    View released{};
  };
  struct Location {
    const void* where = nullptr;
    std::vector<Store> stores;
    std::uint16_t last_sequential = 0;  // store of memory_order_seq_cst
    std::uint16_t last_write = 0;       // of bytes
  };

  std::size_t find(const void* where, std::uint64_t newest);
  std::uint16_t choose(int thread, std::size_t location, std::memory_order order);
  void acquire(int thread, std::size_t location, std::uint16_t store, std::memory_order order);
  void append(int thread, std::size_t location, std::uint64_t value, std::memory_order order,
              const View& passed_on);
  View& view(int thread) { return views_[static_cast<std::size_t>(thread)]; }

  std::mt19937 random_;
  std::vector<Location> locations_;
  std::size_t used_ = 0;
  std::array<View, Scheduler::kThreadsMax> views_{};
  bool raced_ = false;
};

}  // namespace tims::sched
