// Calls of the scheduled build of libtims/shm before every operation on shared memory.
#pragma once

#include <cstdint>
#include <functional>

namespace tims::sched {

enum class Access : std::uint8_t { kRead, kWrite };

struct Operation {
  const void* where = nullptr;  // nullptr: accesses nothing that is shared
  Access access = Access::kRead;
  bool waits = false;  // for a condition
  // For a compare-and-swap: whether it would succeed now. A failing one only reads.
  bool (*succeeds)(const void* where, std::uint64_t expected) = nullptr;
  std::uint64_t expected = 0;
};
// Whether the order of the two can affect the result.
constexpr bool dependent(Operation a, Operation b) {
  return a.where != nullptr && a.where == b.where &&
         (a.access == Access::kWrite || b.access == Access::kWrite);
}

// Other logical threads may run before this returns, or this thread may crash here. Outside of a
// schedule it counts for the StepLimit, if there is one.
void step(Operation next);

// Returns once `condition` holds; it must depend only on the memory at `where`.
void wait_until(const void* where, std::function<bool()> condition);

// Reading and writing bytes that are not atomic; these are steps as well.
void read_bytes(const void* where);
void write_bytes(const void* where);

// The memory and the thread of the present step, in a schedule on weak memory.
class WeakMemory;
struct WeakStep {
  WeakMemory* memory = nullptr;
  int thread = 0;
};
WeakStep weak_step();
// The kernel has reported the end of another thread to this one, which synchronises with all
// stores.
void learn_everything();

// Outside of a schedule: throws when an operation takes too many steps, and calls `before_step`
// before every step, for interference.
class StepLimit {
 public:
  struct Exceeded {};
  explicit StepLimit(std::uint64_t steps_max, std::function<void()> before_step = {});
  ~StepLimit();
  StepLimit(const StepLimit&) = delete;
  StepLimit& operator=(const StepLimit&) = delete;

  void count() {
    if (++steps_ > steps_max_) throw Exceeded{};
    if (before_step_) before_step_();
  }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

 private:
  std::uint64_t steps_ = 0;
  std::uint64_t steps_max_;
  std::function<void()> before_step_;
};

}  // namespace tims::sched
