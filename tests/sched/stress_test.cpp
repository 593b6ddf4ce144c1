// Real threads on one mailbox, mainly for the thread sanitizer, which must see a single mapping.
// Bounded by the number of messages, not by time.
#include <array>
#include <atomic>
#include <cstring>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "os/wakeup.h"
#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "wire/header.h"

namespace tims::shm {
namespace stress_test {

constexpr std::size_t kBodyBytes = 100;
constexpr std::uint32_t kLength = kHeaderSize + kBodyBytes;
constexpr std::uint32_t kPriorities = 3;
constexpr std::uint32_t kDoomed = 0x800;  // writers from here on leave a slot half-written

struct Load {
  std::uint32_t slots = 16;
  std::uint32_t producers = 3;
  std::uint32_t messages = 10000;  // per producer
  std::uint32_t seed = 1;
};

std::byte pattern(std::uint32_t writer, std::uint32_t number, std::size_t at) {
  return static_cast<std::byte>(writer * 101 + number * 37 + at);
}

class Stress {
 public:
  explicit Stress(const Load& load)
      : load_(load),
        memory_(new(std::align_val_t{kMailboxAlign})
                    std::byte[Geometry::of(load.slots, kLength).bytes]()),
        view_(MailboxView::create(
            {memory_.get(), Geometry::of(load.slots, kLength).bytes}, 0,
            {.address = Address(1), .slots = load.slots, .message_max = kLength})),
        receiver_(view_) {}

  void run() {
    std::thread owner([this] { receive_all(); });
    std::thread releaser([this] { release_all(); });
    std::vector<std::thread> producers;
    for (std::uint32_t i = 1; i <= load_.producers; ++i)
      producers.emplace_back([this, i] { produce(i); });
    for (std::thread& producer : producers) producer.join();
    done_.store(true);
    wake();
    owner.join();
    releaser.join();
    check_account();
  }

 private:
  struct Free {
    void operator()(std::byte* memory) const {
      ::operator delete[](memory, std::align_val_t{kMailboxAlign});
    }
  };

  void produce(std::uint32_t writer) {
    std::mt19937 random(load_.seed * 100 + writer);
    Sender sender(view_, writer);
    for (std::uint32_t number = 1; number <= load_.messages; ++number) {
      const auto priority = static_cast<std::uint8_t>(random() % kPriorities);
      if (random() % 64 == 0) die_writing(kDoomed + writer);
      send(sender, writer, number, priority, random() % 16 == 0);
      if (random() % 32 == 0) std::this_thread::yield();
    }
  }

  void send(Sender& sender, std::uint32_t writer, std::uint32_t number, std::uint8_t priority,
            bool give_up) {
    Claim claim;
    const SendOutcome outcome = sender.claim(kLength, priority, claim);
    if (outcome == SendOutcome::kReplaced) replaced_.fetch_add(1);
    if (!taken(outcome)) {
      refused_.fetch_add(1);
      return;
    }
    const Header header{
        .priority = priority, .dest = Address(number), .src = Address(writer), .length = kLength};
    wire::encode_header(header, wire::HeaderBytes(claim.header, kHeaderSize));
    for (std::size_t i = 0; i < kBodyBytes; ++i) claim.body[i] = pattern(writer, number, i);
    if (give_up) return sender.give_up(claim);
    ASSERT_EQ(sender.commit(claim), SendOutcome::kOk);
    committed_.fetch_add(1);
    if (sender.sleeper() != 0) wake();
  }

  // A sender claims a slot and crashes; the router reclaims the slot.
  void die_writing(std::uint32_t writer) {
    Sender sender(view_, writer);
    Claim claim;
    const SendOutcome outcome = sender.claim(kLength, 0, claim);
    if (outcome == SendOutcome::kReplaced) replaced_.fetch_add(1);
    if (outcome == SendOutcome::kFull) refused_.fetch_add(1);
    reclaim(view_, [writer](std::uint32_t candidate) { return candidate == writer; });
    wake();
  }

  void wake() { os::futex_clear_and_wake(*view_.header().sleep.raw()); }

  void receive_all() {
    for (;;) {
      const bool last =
          done_.load();  // read before polling: all messages are in the mailbox by then
      if (const auto got = receiver_.take()) {
        check(*got);
        hand_over(got->hint);
      } else if (last) {
        break;
      } else {
        sleep();
      }
    }
    handed_over_all_.store(true);
  }

  void sleep() {
    const std::uint32_t armed = receiver_.arm();
    if (receiver_.nothing_came() && !done_.load())
      os::futex_wait(*view_.header().sleep.raw(), armed, kNever);
    receiver_.disarm();
  }

  void check(const Taken& got) {
    const std::uint32_t writer = got.header.src.raw();
    const std::uint32_t number = got.header.dest.raw();
    ASSERT_EQ(got.body.size(), kBodyBytes);
    ASSERT_TRUE(writer >= 1 && writer <= load_.producers);
    for (std::size_t i = 0; i < kBodyBytes; ++i)
      ASSERT_EQ(got.body[i], pattern(writer, number, i)) << "torn: " << writer << ", " << number;
    std::uint32_t& last = last_[writer][got.header.priority];
    ASSERT_GT(number, last) << "out of order: writer " << writer;
    last = number;
    ++received_;
  }

  // Every second slot is released by another thread of the owner.
  void hand_over(Hint hint) {
    if (received_ % 2 == 0 || handed_over_.load() != 0) return receiver_.release(hint);
    handed_over_.store(hint.pack() | kPresent);
  }
  void release_all() {
    for (;;) {
      const bool last = handed_over_all_.load();
      if (const std::uint64_t hint = handed_over_.load(); hint != 0) {
        receiver_.release(Hint::unpack(hint & ~kPresent));
        handed_over_.store(0);
      } else if (last) {
        return;
      } else {
        std::this_thread::yield();
      }
    }
  }

  void check_account() {
    const MailboxHeader& header = view_.header();
    EXPECT_EQ(received_ + replaced_.load(), committed_.load());
    EXPECT_EQ(header.replaced.load(std::memory_order_relaxed), replaced_.load());
    EXPECT_EQ(header.refused.load(std::memory_order_relaxed), refused_.load());
    EXPECT_EQ(header.received.load(std::memory_order_relaxed), received_);
    EXPECT_GT(received_, 0U);
    Sender sender(view_, 1);
    Claim claim;
    for (std::uint32_t i = 0; i < load_.slots; ++i)
      EXPECT_EQ(sender.claim(kLength, 0, claim), SendOutcome::kOk) << "a slot is lost";
  }

  static constexpr std::uint64_t kPresent = std::uint64_t{1} << 63;  // a bit that is not used here

  const Load load_;
  std::unique_ptr<std::byte[], Free> memory_;
  MailboxView view_;
  Receiver receiver_;
  std::array<std::array<std::uint32_t, kPriorities>, 16> last_{};
  std::uint64_t received_ = 0;
  std::atomic<std::uint64_t> committed_ = 0;
  std::atomic<std::uint64_t> replaced_ = 0;
  std::atomic<std::uint64_t> refused_ = 0;
  std::atomic<std::uint64_t> handed_over_ = 0;
  std::atomic<bool> done_ = false;
  std::atomic<bool> handed_over_all_ = false;
};

TEST(MailboxStress, ManySlots) { Stress({.slots = 256, .seed = 1}).run(); }
TEST(MailboxStress, AFewSlots) { Stress({.slots = 8, .seed = 2}).run(); }
TEST(MailboxStress, TwoSlots) { Stress({.slots = 2, .producers = 4, .seed = 3}).run(); }
TEST(MailboxStress, OneSlot) { Stress({.slots = 1, .seed = 4}).run(); }
TEST(MailboxStress, OneProducer) { Stress({.producers = 1, .messages = 30000, .seed = 5}).run(); }

}  // namespace stress_test
}  // namespace tims::shm
