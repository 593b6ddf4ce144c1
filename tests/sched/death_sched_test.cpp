// A producer, the first actor, crashes at each of its steps, under all interleavings with the other
// actors. The router then releases its slots and wakes the owner.
#include <gtest/gtest.h>

#include "tests/sched/actors.h"
#include "tests/support/patience.h"

namespace tims::sched {
namespace death_sched_test {

TEST(DeathSched, WhileTheOwnerSleeps) {
  explore_deaths({.actors = {producer(2), sleepy_owner(1), router(2)}}, all_traces());
  explore_deaths({.actors = {producer(2, 2), sleepy_owner(3), router(2)}}, all_traces());
  explore_deaths({.actors = {producer(2), producer(3), sleepy_owner(1), router(2)}},
                 few_preemptions(1));
}

TEST(DeathSched, BesideAnotherProducer) {
  explore_deaths({.actors = {producer(2), producer(3), owner(1), router(2)}}, all_traces());
}

TEST(DeathSched, AtTheEndsOfTheRings) {
  explore_deaths(
      {.set_stage = near_the_end(1), .actors = {producer(2), producer(3), owner(2), router(2)}},
      all_traces());
}

TEST(DeathSched, FullMailbox) {
  explore_deaths({.set_stage = waiting({0, 0}), .actors = {producer(2), owner(2), router(2)}},
                 all_traces());
  explore_deaths(
      {.set_stage = waiting({0, 0}), .actors = {producer(2), producer(3), owner(1), router(2)}},
      few_preemptions(1));
}

TEST(DeathSched, FullMailboxOfOneSlot) {
  explore_deaths({.slots = 1,
                  .set_stage = waiting({0}),
                  .actors = {producer(2), producer(3), owner(1), router(2)}},
                 few_preemptions(1));
}

TEST(DeathSched, OverrunArrivalRing) {
  explore_deaths({.set_stage = overrun_but_for(1), .actors = {producer(2, 2), owner(2), router(2)}},
                 all_traces());
  explore_deaths({.slots = 1,
                  .set_stage = overrun_but_for(1),
                  .actors = {producer(2, 2), producer(3), owner(2), router(2)}},
                 few_preemptions(1));
}

TEST(DeathSched, WhileGivingUpALoan) {
  explore_deaths({.actors = {borrower(2), producer(3), owner(2), router(2)}}, all_traces());
}

// The router may take a running writer for crashed. The result of its commit() must still be right.
TEST(DeathSched, WrongSuspicion) {
  const Actor mistaken{"router", [](MailboxFixture& fixture) { fixture.reclaim_slots_of(2); }};
  explore({.actors = {producer(2, 2), owner(2), mistaken}}, all_traces());
}

TEST(DeathSched, AmongManyAtRandom) {
  const Scenario scenario{
      .slots = 3,
      .set_stage = overrun_but_for(2),
      .actors = {producer(2, 3), producer(3, 3, 1), producer(4, 3), owner(6), router(2)}};
  explore_deaths(scenario, random_schedules(test::rounds(300)));
}

}  // namespace death_sched_test
}  // namespace tims::sched
