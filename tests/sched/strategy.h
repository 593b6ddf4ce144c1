// Strategies choose the thread of every step, and so the schedules of a scenario, run by run.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/sched/step.h"

namespace tims::sched {

// Bit i: thread i.
using Threads = std::uint32_t;

inline int first_of(Threads threads) { return std::countr_zero(threads); }
constexpr Threads only(int thread) { return Threads{1} << thread; }
constexpr bool contains(Threads threads, int thread) { return (threads & only(thread)) != 0; }

// What a strategy sees before every step.
struct Moment {
  std::span<const Operation> next;  // of every thread
  Threads alive = 0;                // neither finished nor crashed
  Threads runnable = 0;             // and not waiting
  int last = -1;                    // the thread of the previous step
};

class Strategy {
 public:
  virtual ~Strategy() = default;
  // One of the runnable threads, of which there is at least one.
  virtual int choose(const Moment& moment) = 0;
  // Called when no thread can continue.
  virtual void at_end(const Moment& /*moment*/) {}
  // After a run: prepares the next; false: there is none.
  virtual bool next_run() = 0;
  // Whether the run that just ended differed from an earlier one only in the order of steps that
  // do not depend on each other.
  [[nodiscard]] virtual bool redundant() const { return false; }
};

}  // namespace tims::sched
