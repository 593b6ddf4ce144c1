// What the scheduled build of libtims/shm says before every operation on shared memory.
#pragma once

#include <cstdint>
#include <functional>

namespace tims::sched {

enum class Access : std::uint8_t { kRead, kWrite };

struct Operation {
  const void* where = nullptr;  // nullptr: touches nothing that others can see
  Access access = Access::kRead;
  bool waits = false;  // for a condition
  // Of a compare-and-swap: whether it would succeed now. One that fails only reads.
  bool (*succeeds)(const void* where, std::uint64_t expected) = nullptr;
  std::uint64_t expected = 0;
};
// Whether it can matter which of the two comes first.
constexpr bool dependent(Operation a, Operation b) {
  return a.where != nullptr && a.where == b.where &&
         (a.access == Access::kWrite || b.access == Access::kWrite);
}

// Other logical threads may go first now, or this one may never go on. Outside of a schedule:
// counts for the StepLimit, if there is one.
void step(Operation next);

// Goes on once `condition`, which depends on nothing but what lies at `where`, holds.
void wait_until(const void* where, std::function<bool()> condition);

// Reading and writing bytes that are not atomic: steps too.
void read_bytes(const void* where);
void write_bytes(const void* where);

// Of this step, in a schedule over weak memory: the memory, and whose step it is.
class WeakMemory;
struct WeakStep {
  WeakMemory* memory = nullptr;
  int thread = 0;
};
WeakStep weak_step();
// The kernel has told this thread of another's end: it knows of everything by now.
void learn_everything();

// Outside of a schedule: ends what does not end by itself, and lets others interfere before every
// step.
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
