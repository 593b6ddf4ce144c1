// The actors of the scenarios, and functions that prepare the mailbox.
#pragma once

#include "tests/sched/explore.h"

namespace tims::sched {

inline Actor producer(std::uint32_t writer, int messages = 1, std::uint8_t priority = 0) {
  return {"producer " + std::to_string(writer), [=](MailboxFixture& fixture) {
            for (int i = 0; i < messages; ++i) fixture.send(writer, priority);
          }};
}
inline Actor borrower(std::uint32_t writer) {
  return {"borrower " + std::to_string(writer),
          [=](MailboxFixture& fixture) { fixture.loan_and_give_up(writer); }};
}
// Polls for a message `looks` times without waiting.
inline Actor owner(int looks) {
  return {"owner", [=](MailboxFixture& fixture) {
            for (int i = 0; i < looks; ++i) fixture.receive();
          }};
}
inline Actor sleepy_owner(int messages) {
  return {"owner", [=](MailboxFixture& fixture) {
            for (int i = 0; i < messages; ++i) fixture.receive_or_sleep();
          }};
}
// Acts after `writer`, the first actor, has crashed.
inline Actor router(std::uint32_t writer) {
  return {"router", [=](MailboxFixture& fixture) { fixture.reclaim_after_death(writer); }};
}

using Stage = std::function<void(MailboxFixture&)>;

// Both rings are `places` before the wrap-around of their indices.
inline Stage near_the_end(std::uint32_t places) {
  return [=](MailboxFixture& fixture) { fixture.advance(fixture.view().geometry().ring - places); };
}
// The owner has not received for so long that only `places` more hints fit into the arrival ring.
inline Stage overrun_but_for(std::uint32_t places) {
  return [=](MailboxFixture& fixture) { fixture.overrun(fixture.view().geometry().ring - places); };
}
inline Stage waiting(std::vector<std::uint8_t> priorities) {
  return [priorities = std::move(priorities)](MailboxFixture& fixture) {
    for (const std::uint8_t priority : priorities) fixture.send(1, priority);
  };
}

}  // namespace tims::sched
