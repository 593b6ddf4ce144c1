// Producers and the owner of a mailbox under their interleavings. Invariants: judge.cpp.
#include <gtest/gtest.h>

#include "tests/sched/actors.h"
#include "tests/support/patience.h"

namespace tims::sched {
namespace mailbox_sched_test {

TEST(MailboxSched, OneProducer) { explore({.actors = {producer(1, 4), owner(4)}}, all_traces()); }

TEST(MailboxSched, TwoProducers) {
  explore({.actors = {producer(1), producer(2), owner(2)}}, all_traces());
  explore({.slots = 3, .actors = {producer(1, 2), producer(2), owner(2)}}, few_preemptions(2));
}

TEST(MailboxSched, TwoProducersAndTooFewSlots) {
  explore({.actors = {producer(1, 2), producer(2), owner(2)}}, few_preemptions(2));
}

TEST(MailboxSched, DifferentPriorities) {
  explore({.slots = 3, .actors = {producer(1, 1, 9), producer(2, 2, 1), owner(2)}},
          few_preemptions(2));
}

TEST(MailboxSched, FullMailbox) {
  const Stage full = waiting({0, 0});
  explore({.set_stage = full, .actors = {producer(2, 2), owner(3)}}, all_traces());
  explore({.set_stage = full, .actors = {producer(2), producer(3), owner(2)}}, all_traces());
}

TEST(MailboxSched, FullMailboxOfDifferentPriorities) {
  explore({.slots = 3,
           .set_stage = waiting({4, 0, 0}),
           .actors = {producer(2), producer(3, 1, 4), owner(2)}},
          few_preemptions(2));
}

TEST(MailboxSched, FullMailboxOfOneSlot) {
  explore({.slots = 1,
           .set_stage = waiting({0}),
           .actors = {producer(2, 2), producer(3, 1, 7), owner(2)}},
          few_preemptions(2));
}

TEST(MailboxSched, NoWakeUpIsLost) {
  explore({.actors = {producer(1, 3), sleepy_owner(3)}}, all_traces());
  explore({.actors = {producer(1), producer(2), sleepy_owner(2)}}, all_traces());
}

TEST(MailboxSched, AroundTheEndsOfTheRings) {
  explore({.set_stage = near_the_end(1), .actors = {producer(1), producer(2), owner(2)}},
          all_traces());
}

TEST(MailboxSched, OverrunByOneProducer) {
  explore({.set_stage = overrun_but_for(0), .actors = {producer(1, 3), owner(3)}}, all_traces());
  explore({.set_stage = overrun_but_for(1), .actors = {producer(1, 3), owner(3)}}, all_traces());
  explore({.slots = 4, .set_stage = overrun_but_for(1), .actors = {producer(1, 4), owner(3)}},
          few_preemptions(2));
}

TEST(MailboxSched, OverrunByTwoProducers) {
  explore({.set_stage = overrun_but_for(1), .actors = {producer(1, 2), producer(2), owner(2)}},
          few_preemptions(2));
}

TEST(MailboxSched, TwoThreadsOfTheOwnerRelease) {
  struct Peeks {
    std::optional<shm::Taken> first;
    std::optional<shm::Taken> second;
  };
  const auto peeks = std::make_shared<Peeks>();
  const auto stage = [peeks](MailboxFixture& fixture) {
    fixture.send(1), fixture.send(1);
    peeks->first = fixture.peek();
    peeks->second = fixture.peek();
  };
  const Actor one{"one", [peeks](MailboxFixture& fixture) { fixture.release(*peeks->first); }};
  const Actor other{"other", [peeks](MailboxFixture& fixture) { fixture.release(*peeks->second); }};
  explore({.set_stage = stage, .actors = {one, other, producer(1, 2)}}, all_traces());
}

TEST(MailboxSched, LoansGivenUp) {
  explore({.slots = 1, .actors = {borrower(2), producer(1), sleepy_owner(1)}}, all_traces());
  explore({.actors = {borrower(2), producer(1, 2), owner(2)}}, few_preemptions(2));
}

TEST(MailboxSched, PutBack) {
  const Actor undecided{
      "owner", [](MailboxFixture& fixture) { fixture.peek_and_put_back(), fixture.receive(); }};
  explore({.set_stage = waiting({0, 0}), .actors = {producer(2, 2), undecided}}, all_traces());
}

TEST(MailboxSched, Closed) {
  const Actor closing{"owner", [](MailboxFixture& fixture) { fixture.receive(), fixture.close(); }};
  explore({.actors = {producer(1, 2), producer(2), closing}}, few_preemptions(2));
}

// Laps (16 bits) and generations (24 bits) wrap around.
TEST(MailboxSched, LapsAndGenerationsWrapAround) {
  Scheduler scheduler;
  MailboxFixture fixture(scheduler);
  fixture.reset(1);
  fixture.age_slots(shm::SlotWord::kMask24 - 1000);
  fixture.advance(3 * 65536 * fixture.view().geometry().ring);
  EXPECT_EQ(fixture.judge({}), std::nullopt);
}

TEST(MailboxSched, ManyMessagesAtRandom) {
  const Scenario scenario{.slots = 3,
                          .set_stage = overrun_but_for(2),
                          .actors = {producer(2, 5), producer(3, 5, 1), producer(4, 5), owner(12)}};
  explore(scenario, random_schedules(test::rounds(30000)));
}

TEST(MailboxSched, SleepyOwnerOfManyMessagesAtRandom) {
  const Scenario scenario{
      .slots = 2,
      .set_stage = near_the_end(3),
      .actors = {producer(2, 4), producer(3, 4, 1), borrower(4), sleepy_owner(5)}};
  explore(scenario, random_schedules(test::rounds(30000)));
}

}  // namespace mailbox_sched_test
}  // namespace tims::sched
