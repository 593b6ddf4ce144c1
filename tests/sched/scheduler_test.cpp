// The scheduler itself: errors it must find, and that its reductions omit no result.
#include "tests/sched/scheduler.h"

#include <set>

#include <gtest/gtest.h>

#include "tests/sched/all_traces.h"
#include "tests/sched/atomic.h"
#include "tests/sched/strategies.h"
#include "tests/support/patience.h"

namespace tims::sched {
namespace scheduler_test {

using Word = shm::Atomic<std::uint32_t>;
using Bodies = std::vector<Scheduler::Body>;
constexpr auto kOrder = std::memory_order_seq_cst;

std::uint32_t value(const Word& word) { return word.raw()->load(); }

struct Search {
  std::set<std::vector<std::uint32_t>> results;
  std::uint64_t runs = 0;
  std::uint64_t redundant = 0;
  Threads stuck = 0;
  bool endless = false;
};

// `make` prepares every run; `result` reads its result.
template <typename Make, typename Result>
Search search(Strategy& strategy, Make make, Result result, std::optional<Death> death = {}) {
  Search found;
  Scheduler scheduler;
  do {
    const Bodies bodies = make();
    const Outcome& outcome = scheduler.run(bodies, strategy, death, [] {});
    ++found.runs;
    found.redundant += strategy.redundant() ? 1 : 0;
    found.stuck |= outcome.stuck;
    found.endless |= outcome.endless;
    found.results.insert(result());
  } while (strategy.next_run());
  return found;
}

// Two threads add 1, not atomically.
class LostUpdate : public testing::Test {
 protected:
  Bodies make() {
    x_.store(0, kOrder);
    const auto add = [this] { x_.store(x_.load(kOrder) + 1, kOrder); };
    return {add, add};
  }
  Search search_with(Strategy& strategy, std::optional<Death> death = {}) {
    return search(
        strategy, [this] { return make(); },
        [this] { return std::vector<std::uint32_t>{value(x_)}; }, death);
  }
  Word x_{0};
};

TEST_F(LostUpdate, NeedsOnePreemption) {
  FewPreemptions none(0);
  FewPreemptions one(1);
  EXPECT_EQ(search_with(none).results.size(), 1U);
  EXPECT_EQ(search_with(one).results.size(), 2U);
}

TEST_F(LostUpdate, IsFoundByAllTracesAndAtRandom) {
  AllTraces all;
  Random random(1, 100);
  EXPECT_EQ(search_with(all).results.size(), 2U);
  EXPECT_EQ(search_with(random).results.size(), 2U);
}

// Three steps each, including the start: 6! / (3! 3!) = 20.
TEST_F(LostUpdate, UnlimitedSearchRunsEveryInterleaving) {
  FewPreemptions all(FewPreemptions::kUnlimited);
  EXPECT_EQ(search_with(all).runs, 20U);
}

TEST_F(LostUpdate, ACrashedThreadDoesNothingMore) {
  for (int step = 0; step < 3; ++step) {
    FewPreemptions all(FewPreemptions::kUnlimited);
    const Search found = search_with(all, Death{0, step});
    EXPECT_EQ(found.results, std::set<std::vector<std::uint32_t>>{{1}}) << step;
  }
  FewPreemptions all(FewPreemptions::kUnlimited);
  EXPECT_EQ(search_with(all, Death{0, 3}).results.size(), 2U) << "it has finished before that step";
}

TEST_F(LostUpdate, IsRepeatedFromItsText) {
  Scheduler scheduler;
  Random random(7, 1000);
  std::vector<int> schedule;
  do {
    const Bodies bodies = make();
    schedule = scheduler.run(bodies, random, {}, [] {}).schedule;
  } while (value(x_) != 1 && random.next_run());
  Replay replay(from_text(to_text(schedule)));
  const Bodies bodies = make();
  EXPECT_EQ(scheduler.run(bodies, replay, {}, [] {}).schedule, schedule);
  EXPECT_EQ(value(x_), 1U);
}

TEST(SchedulerTest, DetectsThreadsThatWaitForEver) {
  Word x{0};
  const auto make = [&]() -> Bodies {
    x.store(0, kOrder);
    return {[&x] { wait_until(&x, [&x] { return value(x) == 1; }); },
            [&x] {
              if (x.fetch_add(1, kOrder) == 0) x.fetch_add(1, kOrder);
            }};
  };
  const auto nothing = [] { return std::vector<std::uint32_t>{}; };
  FewPreemptions calm(0);
  AllTraces all;
  EXPECT_EQ(search(calm, make, nothing).stuck, only(0));
  EXPECT_EQ(search(all, make, nothing).stuck, only(0));
}

TEST(SchedulerTest, StopsEndlessLoops) {
  Word x{0};
  const auto make = [&]() -> Bodies {
    return {[&x] {
      while (x.load(kOrder) == 0) {
      }
    }};
  };
  FewPreemptions calm(0);
  EXPECT_TRUE(search(calm, make, [] { return std::vector<std::uint32_t>{}; }).endless);
}

TEST(SchedulerTest, LimitOutsideOfASchedule) {
  Word x{0};
  StepLimit limit(10);
  for (int i = 0; i < 10; ++i) x.load(kOrder);
  EXPECT_THROW(x.load(kOrder), StepLimit::Exceeded);
}

// Small random programs: three threads, two variables, a few operations each.
class SmallProgram {
 public:
  explicit SmallProgram(std::uint32_t seed) {
    std::mt19937 random(seed);
    for (auto& thread : threads_)
      for (std::size_t i = 0; i < 2 + random() % 2; ++i) thread.push_back(random() % 8);
  }
  Bodies make() {
    for (Word& word : words_) word.store(0, kOrder);
    seen_.assign(threads_.size(), 0);
    Bodies bodies;
    for (std::size_t t = 0; t < threads_.size(); ++t)
      bodies.emplace_back([this, t] {
        for (const std::uint32_t operation : threads_[t]) act(t, operation);
      });
    return bodies;
  }
  std::vector<std::uint32_t> result() const {
    std::vector<std::uint32_t> all = seen_;
    for (const Word& word : words_) all.push_back(value(word));
    return all;
  }

 private:
  void act(std::size_t t, std::uint32_t operation) {
    Word& word = words_[operation % 2];
    const auto mark = static_cast<std::uint32_t>(t + 1);
    switch (operation / 2) {
      case 0:
        seen_[t] = seen_[t] * 10 + word.load(kOrder);
        break;
      case 1:
        word.store(mark, kOrder);
        break;
      case 2:
        word.compare_exchange(0, mark, kOrder);
        break;
      default:
        wait_until(&word, [&word] { return value(word) != 2; });
    }
  }
  std::array<std::vector<std::uint32_t>, 3> threads_;
  std::array<Word, 2> words_;
  std::vector<std::uint32_t> seen_;
};

TEST(AllTracesTest, ReachesEveryResultThatAllInterleavingsReach) {
  std::uint64_t all_runs = 0;
  std::uint64_t trace_runs = 0;
  for (std::uint32_t seed = 1; seed <= test::rounds(100); ++seed) {
    SmallProgram program(seed);
    const auto make = [&program] { return program.make(); };
    const auto result = [&program] { return program.result(); };
    FewPreemptions all(FewPreemptions::kUnlimited);
    AllTraces traces;
    const Search expected = search(all, make, result);
    const Search reduced = search(traces, make, result);
    ASSERT_EQ(reduced.results, expected.results) << "seed " << seed;
    ASSERT_EQ(reduced.stuck, expected.stuck) << "seed " << seed;
    all_runs += expected.runs;
    trace_runs += reduced.runs;
  }
  EXPECT_LT(trace_runs * 10, all_runs) << "no reduction";
}

TEST(AllTracesTest, IndependentThreadsHaveOneTrace) {
  std::array<Word, 3> words;
  const auto make = [&words]() -> Bodies {
    Bodies bodies;
    for (Word& word : words) bodies.emplace_back([&word] { word.fetch_add(1, kOrder); });
    return bodies;
  };
  AllTraces traces;
  EXPECT_EQ(search(traces, make, [] { return std::vector<std::uint32_t>{}; }).runs, 1U);
}

}  // namespace scheduler_test
}  // namespace tims::sched
