#include "tests/sched/explore.h"

#include <cstdlib>
#include <iostream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/sched/all_traces.h"
#include "tests/sched/strategies.h"
#include "tests/sched/weak_memory.h"
#include "tests/support/patience.h"

namespace tims::sched {
namespace {

// Replays a schedule and prints every step.
class PrintedReplay : public Strategy {
 public:
  PrintedReplay(const Scenario& scenario, const MailboxFixture& fixture, std::vector<int> schedule)
      : scenario_(scenario), fixture_(fixture), replay_(std::move(schedule)) {}

  int choose(const Moment& moment) override {
    const int chosen = replay_.choose(moment);
    const auto index = static_cast<std::size_t>(chosen);
    std::cout << scenario_.actors[index].name << " " << fixture_.name_of(moment.next[index])
              << '\n';
    return chosen;
  }
  bool next_run() override { return false; }

 private:
  const Scenario& scenario_;
  const MailboxFixture& fixture_;
  Replay replay_;
};

struct Request {
  std::vector<int> schedule;
  std::optional<Death> death;
  std::uint32_t memory_seed = 0;
};
// The schedule given in the environment, if any.
std::optional<Request> requested() {
  const auto text_of = [](const char* name) {
    const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): never set here
    return std::string(text == nullptr ? "" : text);
  };
  Request request;
  request.schedule = from_text(text_of("TIMS_SCHEDULE"));
  if (request.schedule.empty()) return std::nullopt;
  Death death;
  char at = 0;
  if (std::istringstream(text_of("TIMS_DEATH")) >> death.thread >> at >> death.step)
    request.death = death;
  std::istringstream(text_of("TIMS_MEMORY")) >> request.memory_seed;
  return request;
}

// The release build explores all schedules; builds with sanitizers, which look for errors within
// single schedules, the first of each exploration.
constexpr std::uint64_t kRunsMax =
    test::kSlowdown == 1 ? std::numeric_limits<std::uint64_t>::max() : 3000;

class Exploration {
 public:
  enum class Memory { kStrong, kWeak };
  Exploration(const Scenario& scenario, Memory memory)
      : scenario_(scenario),
        weak_(memory == Memory::kWeak),
        fixture_(scheduler_, weak_ ? &memory_ : nullptr) {
    if (weak_) scheduler_.use_memory(&memory_);
    for (const Actor& actor : scenario_.actors)
      bodies_.emplace_back([this, &actor] { actor.act(fixture_); });
  }

  void run_all(const MakeStrategy& strategy) {
    if (run_requested()) return;
    run_all(*strategy(), {});
    print_count();
  }
  // Crashes the first actor at each of its steps.
  void run_all_deaths(const MakeStrategy& strategy) {
    if (run_requested()) return;
    died_ = true;
    for (int step = 0; died_ && !testing::Test::HasFailure(); ++step) {
      died_ = false;
      run_all(*strategy(), Death{0, step});
    }
    print_count();
  }

 private:
  void run_all(Strategy& strategy, std::optional<Death> death) {
    const std::uint64_t begin = runs_;
    do {
      const auto seed = static_cast<std::uint32_t>(runs_);
      const Outcome& outcome = run_one(strategy, death, seed);
      died_ = died_ || outcome.died;
      if (const auto problem = fixture_.judge(outcome)) return fail(*problem, outcome, death, seed);
      runs_ += strategy.redundant() ? 0 : 1;
    } while (runs_ - begin < kRunsMax && strategy.next_run());
  }
  bool run_requested() {
    const auto request = requested();
    if (!request) return false;
    PrintedReplay printed(scenario_, fixture_, request->schedule);
    const auto problem = fixture_.judge(run_one(printed, request->death, request->memory_seed));
    EXPECT_FALSE(problem) << *problem;
    return true;
  }
  const Outcome& run_one(Strategy& strategy, std::optional<Death> death, std::uint32_t seed) {
    memory_.reset(seed);
    fixture_.reset(scenario_.slots);
    scenario_.set_stage(fixture_);
    return scheduler_.run(bodies_, strategy, death, [this] { fixture_.observe(); });
  }
  void fail(const std::string& problem, const Outcome& outcome, std::optional<Death> death,
            std::uint32_t seed) const {
    std::ostringstream text;
    text << problem << "\nafter " << runs_ << " schedules; to repeat this one: ";
    if (weak_) text << "TIMS_MEMORY=" << seed << ' ';
    if (death) text << "TIMS_DEATH=" << death->thread << '@' << death->step << ' ';
    text << "TIMS_SCHEDULE=\"" << to_text(outcome.schedule) << '"';
    ADD_FAILURE() << text.str();
  }
  void print_count() const { std::cout << "[schedules ] " << runs_ << '\n'; }

  const Scenario& scenario_;
  bool weak_;
  WeakMemory memory_;
  Scheduler scheduler_;
  MailboxFixture fixture_;
  std::vector<Scheduler::Body> bodies_;
  std::uint64_t runs_ = 0;
  bool died_ = false;
};

}  // namespace

MakeStrategy few_preemptions(int preemptions_max) {
  return [=] { return std::make_unique<FewPreemptions>(preemptions_max); };
}
MakeStrategy all_traces() {
  return [] { return std::make_unique<AllTraces>(); };
}
MakeStrategy random_schedules(std::uint64_t runs, std::uint32_t seed) {
  return [=] { return std::make_unique<Random>(seed, runs); };
}

void explore(const Scenario& scenario, const MakeStrategy& strategy) {
  Exploration(scenario, Exploration::Memory::kStrong).run_all(strategy);
}
void explore_deaths(const Scenario& scenario, const MakeStrategy& strategy) {
  Exploration(scenario, Exploration::Memory::kStrong).run_all_deaths(strategy);
}
void explore_weak(const Scenario& scenario, std::uint64_t runs) {
  Exploration(scenario, Exploration::Memory::kWeak).run_all(random_schedules(runs));
}
void explore_weak_deaths(const Scenario& scenario, std::uint64_t runs) {
  Exploration(scenario, Exploration::Memory::kWeak).run_all_deaths(random_schedules(runs));
}

}  // namespace tims::sched
