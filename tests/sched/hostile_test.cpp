// A mailbox that is corrupted between any two steps of its users: no user may access memory outside
// the mapping (the pages around it are not accessible) or loop for ever.
#include <algorithm>
#include <cstring>
#include <iostream>
#include <optional>

#include <gtest/gtest.h>

#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/sched/hostile_memory.h"
#include "tests/sched/step.h"
#include "wire/header.h"

namespace tims::shm {
namespace hostile_test {

// Performs the operations of a client, the owner and the router on the corrupted mailbox.
class Victim {
 public:
  Victim(const MailboxView& view, std::span<std::byte> mailbox)
      : mailbox_(mailbox), sender_(view, 1), receiver_(view) {}

  void do_something(std::uint32_t what) {
    const auto priority = static_cast<std::uint8_t>(what >> 8);
    switch (what % 10) {
      case 0:
      case 1:
      case 2:
        return send(priority);
      case 3:
      case 4:
        return receive();
      case 5:
        return hold();
      case 6:
        return borrow(priority);
      case 7:
        return sleep();
      case 8:
        return look_around();
      default:
        if (what % 7 == 0) receiver_.clean();
        reclaim(sender_.view(), [](std::uint32_t writer) { return writer % 2 == 0; });
    }
  }

  [[nodiscard]] std::uint64_t got_something() const { return std::min(claimed_, taken_); }

 private:
  void send(std::uint8_t priority) {
    Claim claim;
    if (!claim_whole(priority, claim)) return;
    sender_.commit(claim);
  }
  bool claim_whole(std::uint8_t priority, Claim& claim) {
    const std::uint32_t size = sender_.view().geometry().message_max;
    if (!taken(sender_.claim(size, priority, claim))) return false;
    expect_inside({claim.header, kHeaderSize});
    expect_inside({claim.body, size - kHeaderSize});
    ++claimed_;
    std::memset(claim.body, priority, size - kHeaderSize);
    wire::encode_header({.priority = priority, .length = size},
                        wire::HeaderBytes(claim.header, kHeaderSize));
    return true;
  }
  void receive() {
    const auto taken = receiver_.take();
    if (!taken) return;
    read(*taken);
    receiver_.release(taken->hint);
  }
  void read(const Taken& taken) {
    expect_inside(taken.body);
    ++taken_;
    for (const std::byte b : taken.body) sum_ += static_cast<std::uint8_t>(b);
  }
  void hold() {
    if (held_) {
      read(*held_);
      held_->body.size() % 2 == 0 ? receiver_.put_back(*held_) : receiver_.release(held_->hint);
      held_.reset();
    } else {
      held_ = receiver_.take();
    }
  }
  void borrow(std::uint8_t priority) {
    Claim claim;
    if (claim_whole(priority, claim)) sender_.give_up(claim);
  }
  void sleep() {
    receiver_.arm();
    sum_ += receiver_.nothing_came() ? 1 : 0;
    sum_ += sender_.sleeper();
    receiver_.disarm();
  }
  void look_around() { sum_ += waiting(receiver_.view()); }
  void expect_inside(std::span<const std::byte> bytes) const {
    EXPECT_GE(bytes.data(), mailbox_.data());
    EXPECT_LE(bytes.data() + bytes.size(), mailbox_.data() + mailbox_.size());
  }

  std::span<std::byte> mailbox_;
  Sender sender_;
  Receiver receiver_;
  std::optional<Taken> held_;
  std::uint64_t claimed_ = 0;
  std::uint64_t taken_ = 0;
  std::uint64_t sum_ = 0;  // of the bytes read, so that the reads are not optimised away
};

struct Attack {
  std::uint32_t slots = 2;
  std::uint32_t message_max = 112;
  std::uint32_t long_places = 0;
  std::uint32_t mean_steps = 4;  // mean number of steps between two corruptions
  std::uint32_t rounds = 60;
};

// Limit of steps per operation; linear in the size of the mailbox.
std::uint64_t steps_max(const Geometry& geometry) {
  return 200 + 8 * std::uint64_t{geometry.ring} + 70 * std::uint64_t{geometry.slots};
}

// Returns the number of steps of the longest operation.
std::uint64_t run_one(const Attack& attack, GuardedMailbox& mailbox, std::uint32_t seed,
                      std::uint64_t& got_something) {
  std::mt19937 random(seed);
  Victim victim(mailbox.lay_out(), mailbox.mailbox());
  Scribbler scribbler(mailbox, seed);
  const auto interfere = [&] {
    if (random() % attack.mean_steps == 0) scribbler.scribble();
  };
  const std::uint64_t limit_steps = steps_max(mailbox.geometry());
  std::uint64_t longest = 0;
  for (int i = 0; i < 300; ++i) {
    const auto what = static_cast<std::uint32_t>(random());
    sched::StepLimit limit(limit_steps, interfere);
    EXPECT_NO_THROW(victim.do_something(what)) << "more than " << limit_steps << " steps: seed "
                                               << seed << ", operation " << i << ": " << what;
    longest = std::max(longest, limit.steps());
  }
  got_something += victim.got_something();
  return longest;
}

void run(const Attack& attack) {
  GuardedMailbox mailbox(attack.slots, attack.message_max, attack.long_places);
  std::uint64_t longest = 0;
  std::uint64_t got_something = 0;
  for (std::uint32_t seed = 1; seed <= attack.rounds && !testing::Test::HasFailure(); ++seed)
    longest = std::max(longest, run_one(attack, mailbox, seed, got_something));
  std::cout << "[steps     ] " << longest << " at most, allowed " << steps_max(mailbox.geometry())
            << "; " << got_something << " messages\n";
  EXPECT_GT(got_something, 3 * attack.rounds)
      << "hardly any message passed: the test has tested nothing";
}

TEST(HostileMemory, OneSlot) { run({.slots = 1, .rounds = 2000}); }
TEST(HostileMemory, TwoSlots) { run({.slots = 2, .rounds = 2000}); }
TEST(HostileMemory, ManySlots) { run({.slots = 100, .rounds = 400}); }
TEST(HostileMemory, ManyMoreSlots) { run({.slots = 3000, .rounds = 40}); }
TEST(HostileMemory, LongMessages) { run({.slots = 3, .message_max = 5000, .rounds = 300}); }
TEST(HostileMemory, SharedPlaces) {
  run({.slots = 4, .message_max = 5000, .long_places = 2, .rounds = 300});
}
TEST(HostileMemory, CorruptionAtEveryStep) { run({.slots = 3, .mean_steps = 1, .rounds = 2000}); }
TEST(HostileMemory, RareCorruption) { run({.slots = 3, .mean_steps = 200, .rounds = 2000}); }

// Stores without counting a step.
template <typename T>
void put(shm::Atomic<T>& word, T value) {
  const_cast<std::atomic<T>*>(word.raw())->store(value);
}

class NastyMailbox : public testing::Test {
 protected:
  SendOutcome send() {
    Claim claim;
    const SendOutcome outcome = sender_.claim(112, 0, claim);
    return taken(outcome) ? sender_.commit(claim) : outcome;
  }
  GuardedMailbox mailbox_{100, 112};
  MailboxView view_ = mailbox_.lay_out();
  const Geometry& geometry_ = mailbox_.geometry();
  Sender sender_{view_, 1};
  Receiver receiver_{view_};
};

// All hints in the arrival ring refer to one message, which exists.
TEST_F(NastyMailbox, AllHintsReferToOneMessage) {
  const SlotWord word{SlotState::kReadable, 7, 0, 1};
  wire::encode_header({.length = 112}, wire::HeaderBytes(view_.message_header(0), kHeaderSize));
  for (std::uint64_t lap = 0; lap < 3; ++lap) {
    put(view_.slot(0).word, word.pack());
    for (std::uint64_t i = lap * geometry_.ring; i < (lap + 1) * geometry_.ring; ++i)
      put(view_.arrival(i), Hint{geometry_.lap_of(i), 1, 7, 0}.pack());
    const sched::StepLimit limit(steps_max(geometry_));
    ASSERT_NO_THROW(ASSERT_TRUE(receiver_.take()));
  }
}

// One corrupted field must not cost senders more than a few steps from then on.
TEST_F(NastyMailbox, TailFarAhead) {
  put(view_.header().arrival_tail, std::uint64_t{12345} * geometry_.ring);
  for (int i = 0; i < 10; ++i) {
    const sched::StepLimit limit(40);
    ASSERT_NO_THROW(EXPECT_EQ(send(), SendOutcome::kOk));
  }
}
TEST_F(NastyMailbox, HintOfAnotherLap) {
  put(view_.arrival(0), Hint{7, 0, 0, 0}.pack());
  for (int i = 0; i < 10; ++i) {
    const sched::StepLimit limit(40);
    ASSERT_NO_THROW(EXPECT_EQ(send(), SendOutcome::kOk));
  }
}

TEST_F(NastyMailbox, EndlessFreeHints) {
  const sched::StepLimit limit(steps_max(geometry_), [this] {
    Word64& head = view_.header().free_head;
    const std::uint64_t next = head.raw()->load() + 1;
    put(view_.free(next), Hint{geometry_.lap_of(next), 99, 0, 3}.pack());
    put(head, next);
  });
  ASSERT_NO_THROW(send());
}

TEST_F(NastyMailbox, SlotStatesThatChangeAtEveryStep) {
  std::uint32_t generation = 0;
  const auto change = [&] {
    ++generation;
    for (std::uint32_t i = 0; i < geometry_.slots; ++i)
      put(view_.slot(i).word, SlotWord{SlotState::kLocked, 0, 0, generation}.pack());
  };
  change();
  const sched::StepLimit limit(steps_max(geometry_), change);
  ASSERT_NO_THROW(EXPECT_EQ(send(), SendOutcome::kFull));
}

TEST(HostileMemory, OpenRefusesOrStaysInsideTheMapping) {
  GuardedMailbox mailbox(4, 112);
  std::mt19937 random(1);
  std::uint32_t opened = 0;
  for (std::uint32_t seed = 1; seed <= 3000; ++seed) {
    mailbox.lay_out();
    Scribbler scribbler(mailbox, seed);
    for (std::uint32_t i = random() % 8; i > 0; --i) scribbler.scribble();
    const auto view = MailboxView::open(mailbox.segment(), mailbox.offset());
    if (!view.ok()) continue;
    ++opened;
    sched::StepLimit limit(100 * steps_max(view->geometry()));
    Victim victim(*view, mailbox.mailbox());
    for (std::uint32_t i = 0; i < 10; ++i) ASSERT_NO_THROW(victim.do_something(seed * 10 + i));
  }
  EXPECT_GT(opened, 100U);
  EXPECT_LT(opened, 2900U);
}

}  // namespace hostile_test
}  // namespace tims::shm
