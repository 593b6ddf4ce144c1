// All interleavings, one of each equivalence class: two schedules are equivalent when they differ
// only in the order of neighbouring steps that do not depend on each other; their results are
// equal.
//
// Dynamic partial-order reduction with source sets and sleep sets (Abdulla, Aronis, Jonsson,
// Sagonas, 2014): where two steps of a run race with each other, the other order is tried as well,
// and nothing else is.
#pragma once

#include <array>
#include <vector>

#include "tests/sched/scheduler.h"
#include "tests/sched/strategy.h"

namespace tims::sched {

class AllTraces : public Strategy {
 public:
  int choose(const Moment& moment) override;
  void at_end(const Moment& moment) override;
  bool next_run() override;
  [[nodiscard]] bool redundant() const override { return redundant_; }

 private:
  // For each thread, the number (from 1) of its last step that happened before.
  using Clock = std::array<std::size_t, Scheduler::kThreadsMax>;
  struct Node {
    Threads runnable = 0;
    Threads to_try = 0;
    Threads asleep = 0;  // sleep set: tried before, and no step since then depends on them
    int chosen = 0;
    Operation operation;
    Clock clock{};  // after the step
  };

  bool extend(const Moment& moment);
  void record(Node& node, Operation operation, std::size_t depth);
  [[nodiscard]] Clock happened_before(int thread, Operation next, std::size_t depth) const;
  void find_races(int thread, Operation next, std::size_t depth);
  void reverse(std::size_t earlier, int thread, const Clock& clock, std::size_t depth);
  [[nodiscard]] Threads could_begin(std::size_t earlier, int thread, const Clock& clock,
                                    std::size_t depth) const;

  std::vector<Node> nodes_;
  std::array<Clock, Scheduler::kThreadsMax> clocks_{};  // of each thread, in this run
  std::size_t depth_ = 0;
  bool redundant_ = false;
};

}  // namespace tims::sched
