// Scenarios, and running all their schedules.
//
// A failure prints the schedule that led to it. TIMS_SCHEDULE="0*12 1*3" (and TIMS_DEATH="1@5" and
// TIMS_MEMORY=7 if printed) in the environment, with --gtest_filter for the test, runs that
// schedule and prints every step.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/sched/mailbox_fixture.h"

namespace tims::sched {

struct Actor {
  std::string name;
  std::function<void(MailboxFixture&)> act;
};
struct Scenario {
  std::uint32_t slots = 2;
  std::function<void(MailboxFixture&)> set_stage = [](MailboxFixture&) {};
  std::vector<Actor> actors;
};

using MakeStrategy = std::function<std::unique_ptr<Strategy>()>;
MakeStrategy few_preemptions(int preemptions_max);
MakeStrategy all_traces();
MakeStrategy random_schedules(std::uint64_t runs, std::uint32_t seed = 1);

// Fails the test with the first schedule that violates an invariant. Prints the number of
// schedules.
void explore(const Scenario& scenario, const MakeStrategy& strategy);
// The same with a crash of the first actor at each of its steps.
void explore_deaths(const Scenario& scenario, const MakeStrategy& strategy);
// On weak memory, with random schedules.
void explore_weak(const Scenario& scenario, std::uint64_t runs);
void explore_weak_deaths(const Scenario& scenario, std::uint64_t runs);

}  // namespace tims::sched
