// The memory orders of libtims/shm: the same code on memory that may return old values. The first
// tests check the simulated memory itself: what each order must allow and forbid.
#include "tests/sched/weak_memory.h"

#include <set>

#include <gtest/gtest.h>

#include "tests/sched/actors.h"
#include "tests/sched/strategies.h"

namespace tims::sched {
namespace weak_memory_test {

using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;

class Litmus : public testing::Test {
 protected:
  using Word = shm::Atomic<std::uint32_t>;
  using Results = std::set<std::pair<std::uint32_t, std::uint32_t>>;

  // All values of a_ and b_ after both threads have finished.
  Results results(const std::function<void()>& one, const std::function<void()>& other) {
    Results found;
    Scheduler scheduler;
    WeakMemory memory;
    scheduler.use_memory(&memory);
    Random random(1, 3000);
    const std::vector<Scheduler::Body> bodies = {one, other};
    std::uint32_t seed = 0;
    do {
      memory.reset(++seed);
      for (Word* word : {&x_, &y_}) word->store(0, memory_order_relaxed);
      a_ = b_ = 0;
      scheduler.run(bodies, random, {}, [] {});
      found.insert({a_, b_});
      raced_ = raced_ || memory.raced();
    } while (random.next_run());
    return found;
  }

  Word x_{0};
  Word y_{0};
  std::uint32_t a_ = 0;
  std::uint32_t b_ = 0;
  bool raced_ = false;
};

TEST_F(Litmus, RelaxedPublishingShowsTheFlagBeforeTheValue) {
  const auto found =
      results([this] { x_.store(1, memory_order_relaxed), y_.store(1, memory_order_relaxed); },
              [this] { a_ = y_.load(memory_order_acquire), b_ = x_.load(memory_order_relaxed); });
  EXPECT_TRUE(found.contains({1, 0}));
}

TEST_F(Litmus, ReleaseAndAcquirePublish) {
  const auto found =
      results([this] { x_.store(1, memory_order_relaxed), y_.store(1, memory_order_release); },
              [this] { a_ = y_.load(memory_order_acquire), b_ = x_.load(memory_order_relaxed); });
  EXPECT_EQ(found, (Results{{0, 0}, {0, 1}, {1, 1}}));
}

TEST_F(Litmus, UpdatesContinueAReleaseSequence) {
  const auto found = results(
      [this] {
        x_.store(1, memory_order_relaxed);
        y_.store(1, memory_order_release);
        y_.fetch_add(1, memory_order_relaxed);
      },
      [this] { a_ = y_.load(memory_order_acquire), b_ = x_.load(memory_order_relaxed); });
  EXPECT_TRUE(found.contains({2, 1}));
  EXPECT_FALSE(found.contains({2, 0}));
}

TEST_F(Litmus, OnlySequentialConsistencyForbidsBothToMissEachOther) {
  const auto with = [this](std::memory_order store, std::memory_order load) {
    return results([=, this] { x_.store(1, store), a_ = y_.load(load); },
                   [=, this] { y_.store(1, store), b_ = x_.load(load); });
  };
  EXPECT_TRUE(with(memory_order_release, memory_order_acquire).contains({0, 0}));
  EXPECT_FALSE(with(memory_order_seq_cst, memory_order_seq_cst).contains({0, 0}));
}

TEST_F(Litmus, ValuesNeverGoBack) {
  const auto found =
      results([this] { x_.store(1, memory_order_relaxed), x_.store(2, memory_order_relaxed); },
              [this] { a_ = x_.load(memory_order_relaxed), b_ = x_.load(memory_order_relaxed); });
  for (const auto& [first, second] : found) EXPECT_LE(first, second);
}

TEST_F(Litmus, BytesNeedAReleaseToBeRead) {
  const auto publish = [this](std::memory_order order) {
    raced_ = false;
    results([=, this] { write_bytes(this), y_.store(1, order); },
            [this] {
              if (y_.load(memory_order_acquire) == 1) read_bytes(this);
            });
    return raced_;
  };
  EXPECT_TRUE(publish(memory_order_relaxed));
  EXPECT_FALSE(publish(memory_order_release));
}

TEST_F(Litmus, BytesNeedAReleaseToBeWrittenAfterReading) {
  const auto give_back = [this](std::memory_order order) {
    raced_ = false;
    results([=, this] { read_bytes(this), y_.store(1, order); },
            [this] {
              if (y_.load(memory_order_acquire) == 1) write_bytes(this);
            });
    return raced_;
  };
  EXPECT_TRUE(give_back(memory_order_relaxed));
  EXPECT_FALSE(give_back(memory_order_release));
}

constexpr std::uint64_t kRuns = 20000;

TEST(WeakMailbox, Producers) {
  explore_weak({.slots = 3, .actors = {producer(1, 3), producer(2, 3), owner(5)}}, kRuns);
}
TEST(WeakMailbox, FullMailbox) {
  explore_weak({.set_stage = waiting({0, 0}), .actors = {producer(2, 3), producer(3, 3), owner(4)}},
               kRuns);
}
TEST(WeakMailbox, SleepyOwner) {
  explore_weak({.slots = 4, .actors = {producer(1, 2), producer(2, 2), sleepy_owner(4)}}, kRuns);
  explore_weak({.slots = 1, .actors = {producer(1, 2), sleepy_owner(1)}}, kRuns);
}
TEST(WeakMailbox, OverrunArrivalRing) {
  explore_weak({.set_stage = overrun_but_for(2),
                .actors = {producer(2, 4), producer(3, 4), sleepy_owner(4)}},
               kRuns);
}
TEST(WeakMailbox, LoansGivenUp) {
  explore_weak({.slots = 1, .actors = {borrower(2), producer(1, 2), sleepy_owner(2)}}, kRuns);
}
TEST(WeakMailbox, Deaths) {
  explore_weak_deaths({.actors = {producer(2, 2), producer(3, 2), sleepy_owner(2), router(2)}},
                      400);
}

}  // namespace weak_memory_test
}  // namespace tims::sched
