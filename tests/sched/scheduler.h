// Runs several logical threads as fibers of one thread, one step at a time. A step ends before
// every operation on shared memory; a strategy chooses the thread that runs next. A run depends
// only on the strategy's choices, so it can be repeated.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <ucontext.h>

#include "tests/sched/strategy.h"

namespace tims::sched {

// A crash: the logical thread does not execute step `step` (from 0) or any later one.
struct Death {
  int thread = 0;
  int step = 0;
};

struct Outcome {
  bool endless = false;       // stopped after kStepsMax steps
  Threads stuck = 0;          // waiting for ever
  bool died = false;          // the thread has reached the step of its Death
  std::vector<int> schedule;  // the thread of each step
};

class Scheduler {
 public:
  static constexpr int kThreadsMax = 8;
  static constexpr int kStepsMax = 5000;
  using Body = std::function<void()>;

  Scheduler();
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  // `after_step` is called after every step; its operations do not count as steps.
  const Outcome& run(std::span<const Body> bodies, Strategy& strategy, std::optional<Death> death,
                     const std::function<void()>& after_step);

  // Takes effect in the next run; nullptr: the machine's memory.
  void use_memory(WeakMemory* memory) { memory_ = memory; }

  // True after the crash; its address can be passed to wait_until().
  [[nodiscard]] const bool& died() const { return outcome_.died; }

  // Operations inside `quietly` do not count as steps.
  template <typename F>
  auto quietly(F f) {
    const Quiet quiet(*this);
    return f();
  }

 private:
  friend void step(Operation next);
  friend void wait_until(const void* where, std::function<bool()> condition);
  friend WeakStep weak_step();

  enum class State : std::uint8_t { kReady, kFinished, kDead };
  struct Fiber {
    ucontext_t context{};
    std::unique_ptr<std::byte[]> stack;
    const Body* body = nullptr;
    State state = State::kFinished;
    std::function<bool()> condition;  // for continuing; empty: none
    int steps = 0;
  };
  struct Quiet {
    explicit Quiet(Scheduler& s) : scheduler(s), before(s.quiet_) { s.quiet_ = true; }
    ~Quiet() { scheduler.quiet_ = before; }
    Scheduler& scheduler;
    bool before;
  };
  static constexpr int kNobody = -1;

  static void entry();
  void prepare(Fiber& fiber, const Body& body);
  void before_step(Operation next, std::function<bool()> condition);
  void end_thread(State state);
  int choose();
  Threads alive() const;
  Threads runnable() const;
  void switch_to(int thread);
  [[nodiscard]] bool dies_now(int thread) const;

  ucontext_t home_{};
  std::array<Fiber, kThreadsMax> fibers_;
  std::array<Operation, kThreadsMax> next_{};
  int count_ = 0;
  int running_ = kNobody;
  bool quiet_ = true;
  WeakMemory* memory_ = nullptr;
  Strategy* strategy_ = nullptr;
  const std::function<void()>* after_step_ = nullptr;
  std::optional<Death> death_;
  Outcome outcome_;
};

}  // namespace tims::sched
