// Like hostile_test.cpp, with the release build of the code and a thread that corrupts the mailbox
// continuously.
#include <atomic>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>

#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/sched/hostile_memory.h"
#include "wire/header.h"

namespace tims::shm {
namespace hostile_thread_test {

class Attacker {
 public:
  Attacker(const GuardedMailbox& mailbox, std::uint32_t seed)
      : scribbler_(mailbox, seed), thread_([this] {
          while (!done_.load(std::memory_order_relaxed)) scribbler_.scribble();
        }) {}
  ~Attacker() {
    done_.store(true);
    thread_.join();
  }

 private:
  Scribbler scribbler_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

std::uint64_t sum_of(std::span<const std::byte> bytes) {
  std::uint64_t sum = 0;
  for (const std::byte b : bytes) sum += static_cast<std::uint8_t>(b);
  return sum;
}

// Performs `operations` of a sender, the owner and the router.
std::uint64_t use(const MailboxView& view, std::uint32_t operations, std::uint32_t seed) {
  std::mt19937 random(seed);
  Sender sender(view, 1);
  Receiver receiver(view);
  const std::uint32_t size = view.geometry().message_max;
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < operations; ++i) {
    Claim claim;
    if (taken(sender.claim(size, static_cast<std::uint8_t>(random()), claim))) {
      wire::encode_header({.length = size}, wire::HeaderBytes(claim.header, kHeaderSize));
      std::memset(claim.body, 1, size - kHeaderSize);
      random() % 8 == 0 ? sender.give_up(claim) : static_cast<void>(sender.commit(claim));
    }
    if (const auto got = receiver.take()) {
      sum += sum_of(got->body);
      receiver.release(got->hint);
    }
    if (i % 64 == 0) sum += reclaim(view, [](std::uint32_t writer) { return writer > 1; });
    if (i % 256 == 0) sum += receiver.clean();
  }
  return sum;
}

TEST(HostileThread, CorruptsTheMailboxContinuously) {
  for (const std::uint32_t slots : {1U, 2U, 16U, 500U}) {
    GuardedMailbox mailbox(slots, 112);
    const MailboxView view = mailbox.lay_out();
    const Attacker attacker(mailbox, slots);
    std::uint64_t sum = 0;
    // The attacker may leave nothing to pass while the system gives this thread no time.
    for (std::uint32_t tries = 0; tries < 20 && sum == 0; ++tries) {
      if (tries > 0) mailbox.lay_out();
      sum = use(view, 6000000 / (slots + 20), slots);
    }
    EXPECT_GT(sum, 0U) << "no message passed: the test has tested nothing";
  }
}

TEST(HostileThread, ChangesTheMailboxWhileItIsOpened) {
  GuardedMailbox mailbox(4, 112);
  mailbox.lay_out();
  const Attacker attacker(mailbox, 1);
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    mailbox.lay_out();
    const auto view = MailboxView::open(mailbox.segment(), mailbox.offset());
    if (view.ok()) sum += use(*view, 20, i);
  }
  EXPECT_GT(sum, 0U);
}

}  // namespace hostile_thread_test
}  // namespace tims::shm
