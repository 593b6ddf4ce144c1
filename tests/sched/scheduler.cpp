#include "tests/sched/scheduler.h"

#include <utility>

#include "tests/sched/weak_memory.h"

namespace tims::sched {
namespace {

constexpr std::size_t kStackBytes = 128 << 10;

// Atomic operations have no argument by which to find their scheduler, and the code between them
// must be the code that ships. Thread-local: tests may run schedulers side by side.
thread_local Scheduler* current_scheduler = nullptr;
thread_local StepLimit* current_limit = nullptr;

}  // namespace

void step(Operation next) {
  if (current_limit != nullptr) current_limit->count();
  if (current_scheduler != nullptr && !current_scheduler->quiet_)
    current_scheduler->before_step(next, {});
}

void wait_until(const void* where, std::function<bool()> condition) {
  current_scheduler->before_step({where, Access::kRead, true}, std::move(condition));
}

WeakStep weak_step() {
  const Scheduler* scheduler = current_scheduler;
  if (scheduler == nullptr || scheduler->quiet_) return {};
  return {scheduler->memory_, scheduler->running_};
}

void learn_everything() {
  if (const auto [memory, thread] = weak_step(); memory != nullptr)
    memory->learn_everything(thread);
}

void read_bytes(const void* where) {
  step({where, Access::kRead});
  if (const auto [memory, thread] = weak_step(); memory != nullptr)
    memory->read_bytes(thread, where);
}

void write_bytes(const void* where) {
  step({where, Access::kWrite});
  if (const auto [memory, thread] = weak_step(); memory != nullptr)
    memory->write_bytes(thread, where);
}

StepLimit::StepLimit(std::uint64_t steps_max, std::function<void()> before_step)
    : steps_max_(steps_max), before_step_(std::move(before_step)) {
  current_limit = this;
}
StepLimit::~StepLimit() { current_limit = nullptr; }

Scheduler::Scheduler() { current_scheduler = this; }
Scheduler::~Scheduler() { current_scheduler = nullptr; }

const Outcome& Scheduler::run(std::span<const Body> bodies, Strategy& strategy,
                              std::optional<Death> death, const std::function<void()>& after_step) {
  strategy_ = &strategy;
  after_step_ = &after_step;
  death_ = death;
  outcome_ = {};
  running_ = kNobody;
  count_ = static_cast<int>(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    prepare(fibers_[i], bodies[i]);
    // Starting is a step as well: a thread may be delayed before it has done anything.
    next_[i] =
        dies_now(static_cast<int>(i)) ? Operation{&outcome_.died, Access::kWrite} : Operation{};
  }
  quiet_ = false;
  switch_to(choose());
  quiet_ = true;
  outcome_.stuck = alive();
  return outcome_;
}

void Scheduler::prepare(Fiber& fiber, const Body& body) {
  if (!fiber.stack) fiber.stack = std::make_unique_for_overwrite<std::byte[]>(kStackBytes);
  ::getcontext(&fiber.context);
  fiber.context.uc_stack.ss_sp = fiber.stack.get();
  fiber.context.uc_stack.ss_size = kStackBytes;
  fiber.context.uc_link = nullptr;
  ::makecontext(&fiber.context, &Scheduler::entry, 0);
  fiber.body = &body;
  fiber.state = State::kReady;
  fiber.condition = {};
  fiber.steps = 0;
}

void Scheduler::entry() {
  Scheduler& self = *current_scheduler;
  Fiber& fiber = self.fibers_[static_cast<std::size_t>(self.running_)];
  if (self.dies_now(self.running_)) self.end_thread(State::kDead);
  ++fiber.steps;
  (*fiber.body)();
  self.end_thread(State::kFinished);
}

// Returns when the strategy has chosen this thread to execute `next`.
void Scheduler::before_step(Operation next, std::function<bool()> condition) {
  const int self = running_;
  Fiber& fiber = fibers_[static_cast<std::size_t>(self)];
  const bool dies = dies_now(self);
  next_[static_cast<std::size_t>(self)] = dies ? Operation{&outcome_.died, Access::kWrite} : next;
  fiber.condition = dies ? std::function<bool()>{} : std::move(condition);
  const int chosen = choose();
  if (chosen != self) switch_to(chosen);
  if (dies) end_thread(State::kDead);
  ++fiber.steps;
}

bool Scheduler::dies_now(int thread) const {
  return death_ && death_->thread == thread &&
         death_->step == fibers_[static_cast<std::size_t>(thread)].steps;
}

void Scheduler::end_thread(State state) {
  fibers_[static_cast<std::size_t>(running_)].state = state;
  if (state == State::kDead) outcome_.died = true;
  switch_to(choose());
}

int Scheduler::choose() {
  const Quiet quiet(*this);
  if (running_ != kNobody) (*after_step_)();
  if (outcome_.schedule.size() >= kStepsMax) {
    outcome_.endless = true;
    return kNobody;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i)
    if (next_[i].succeeds != nullptr)
      next_[i].access =
          next_[i].succeeds(next_[i].where, next_[i].expected) ? Access::kWrite : Access::kRead;
  const std::span next(next_.data(), static_cast<std::size_t>(count_));
  const Moment moment{next, alive(), runnable(), running_};
  if (moment.runnable == 0) {
    strategy_->at_end(moment);
    return kNobody;
  }
  const int chosen = strategy_->choose(moment);
  outcome_.schedule.push_back(chosen);
  return chosen;
}

Threads Scheduler::alive() const {
  Threads threads = 0;
  for (int i = 0; i < count_; ++i)
    if (fibers_[static_cast<std::size_t>(i)].state == State::kReady) threads |= only(i);
  return threads;
}

Threads Scheduler::runnable() const {
  Threads threads = alive();
  for (int i = 0; i < count_; ++i) {
    const auto& condition = fibers_[static_cast<std::size_t>(i)].condition;
    if (condition && !condition()) threads &= ~only(i);
  }
  return threads;
}

void Scheduler::switch_to(int thread) {
  const int before = std::exchange(running_, thread);
  const auto context = [this](int i) {
    return i == kNobody ? &home_ : &fibers_[static_cast<std::size_t>(i)].context;
  };
  if (before != thread) ::swapcontext(context(before), context(thread));
}

}  // namespace tims::sched
