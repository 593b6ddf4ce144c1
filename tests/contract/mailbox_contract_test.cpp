// The two queues in which messages wait for their receiver: a mailbox in shared memory, and the
// queue of a port of the router for a client that reads slowly. Both have the same order and the
// same rule for the message that is replaced when the queue is full. Pure: no process, no clock.
#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "router/core/byte_chain.h"
#include "router/core/message_queue.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "wire/header.h"

namespace tims {
namespace mailbox_contract_test {

constexpr std::size_t kBody =
    84;  // the same for every message here, so that the limits in messages and in bytes agree
constexpr std::uint32_t kLength = kHeaderSize + kBody;

std::vector<std::byte> message(std::uint32_t number, std::uint8_t priority) {
  std::vector<std::byte> bytes(kLength, static_cast<std::byte>(number));
  wire::encode_header({.priority = priority, .length = kLength},
                      std::span(bytes).first<kHeaderSize>());
  std::memcpy(bytes.data() + kHeaderSize, &number, sizeof number);
  return bytes;
}

enum class Put : std::uint8_t { kTaken, kTakenForAnother, kRefused };

class SharedMailbox {
 public:
  explicit SharedMailbox(std::uint32_t places)
      : size_(shm::Geometry::of(places, kLength, 0).bytes),
        memory_(static_cast<std::byte*>(::operator new(size_, std::align_val_t{128}))) {
    std::memset(memory_.get(), 0, size_);
    view_ =
        shm::MailboxView::create({memory_.get(), size_}, 0,
                                 {.address = Address(7), .slots = places, .message_max = kLength});
    receiver_.emplace(view_);
    sender_.emplace(view_, 1);
  }
  Put put(std::uint32_t number, std::uint8_t priority) {
    shm::Claim claim;
    const shm::SendOutcome outcome = sender_->claim(kLength, priority, claim);
    if (!shm::taken(outcome)) return Put::kRefused;
    const auto bytes = message(number, priority);
    std::memcpy(claim.header, bytes.data(), kHeaderSize);
    std::memcpy(claim.body, bytes.data() + kHeaderSize, kBody);
    EXPECT_EQ(sender_->commit(claim), shm::SendOutcome::kOk);
    return outcome == shm::SendOutcome::kReplaced ? Put::kTakenForAnother : Put::kTaken;
  }
  std::optional<std::uint32_t> take() {
    const auto taken = receiver_->take();
    if (!taken) return std::nullopt;
    std::uint32_t number = 0;
    std::memcpy(&number, taken->body.data(), sizeof number);
    receiver_->release(taken->hint);
    return number;
  }
  std::uint64_t replaced() const { return view_.header().replaced.load(std::memory_order_relaxed); }

 private:
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete(memory, std::align_val_t{128}); }
  };
  std::size_t size_;
  std::unique_ptr<std::byte, Free> memory_;
  shm::MailboxView view_;
  std::optional<shm::Receiver> receiver_;
  std::optional<shm::Sender> sender_;
};

class PortsQueue {
 public:
  explicit PortsQueue(std::uint32_t places) : queue_(pool_, std::uint64_t{places} * kLength) {}
  Put put(std::uint32_t number, std::uint8_t priority) {
    const std::uint64_t before = replaced();
    if (!queue_.push(message(number, priority), priority, replaced_)) return Put::kRefused;
    return replaced() > before ? Put::kTakenForAnother : Put::kTaken;
  }
  std::optional<std::uint32_t> take() {
    if (queue_.empty()) return std::nullopt;
    std::array<std::span<const std::byte>, 64> pieces;
    std::vector<std::byte> bytes;
    for (std::size_t i = 0, n = queue_.gather(pieces); i < n && bytes.size() < kLength; ++i)
      bytes.insert(bytes.end(), pieces[i].begin(), pieces[i].end());
    queue_.consume(kLength);
    std::uint32_t number = 0;
    std::memcpy(&number, bytes.data() + kHeaderSize, sizeof number);
    return number;
  }
  std::uint64_t replaced() const {
    std::uint64_t messages = 0;
    for (const core::Count& count : replaced_) messages += count.messages;
    return messages;
  }

 private:
  std::vector<std::byte> memory_ = std::vector<std::byte>(300 * core::BlockPool::kBlockSize);
  core::BlockPool pool_{memory_};
  core::LossCounts replaced_{};
  core::MessageQueue queue_;
};

template <typename Mailbox>
class MailboxContract : public testing::Test {
 protected:
  static std::vector<std::uint32_t> drain(Mailbox& mailbox) {
    std::vector<std::uint32_t> numbers;
    while (const auto number = mailbox.take()) numbers.push_back(*number);
    return numbers;
  }
};

struct Names {
  template <typename Mailbox>
  static std::string GetName(int) {
    return std::is_same_v<Mailbox, SharedMailbox> ? "SharedMemory" : "PortsQueue";
  }
};
using Mailboxes = testing::Types<SharedMailbox, PortsQueue>;
TYPED_TEST_SUITE(MailboxContract, Mailboxes, Names);

using Numbers = std::vector<std::uint32_t>;
using Priorities = std::vector<std::uint8_t>;

TYPED_TEST(MailboxContract, HigherPriorityFirstThenByArrival) {
  TypeParam mailbox(8);
  std::uint32_t number = 0;
  for (const std::uint8_t priority : Priorities{1, 200, 1, 200, 100})
    EXPECT_EQ(mailbox.put(number++, priority), Put::kTaken);
  EXPECT_EQ(this->drain(mailbox), (Numbers{1, 3, 4, 0, 2}));
}

TYPED_TEST(MailboxContract, PrioritiesAreUnsigned) {
  TypeParam mailbox(8);
  std::uint32_t number = 0;
  for (const std::uint8_t priority : Priorities{0, 127, 128, 255}) mailbox.put(number++, priority);
  EXPECT_EQ(this->drain(mailbox), (Numbers{3, 2, 1, 0}));
}

TYPED_TEST(MailboxContract, WhenFullTheOldestOfTheLowestPriorityIsReplaced) {
  TypeParam mailbox(3);
  mailbox.put(0, 5);
  mailbox.put(1, 3);
  mailbox.put(2, 3);
  EXPECT_EQ(mailbox.put(3, 4), Put::kTakenForAnother);
  EXPECT_EQ(mailbox.replaced(), 1U);
  EXPECT_EQ(this->drain(mailbox), (Numbers{0, 3, 2}));
}

TYPED_TEST(MailboxContract, WhenFullAMessageOfEqualPriorityIsReplaced) {
  TypeParam mailbox(2);
  mailbox.put(0, 9);
  mailbox.put(1, 9);
  EXPECT_EQ(mailbox.put(2, 9), Put::kTakenForAnother);
  EXPECT_EQ(this->drain(mailbox), (Numbers{1, 2}));
}

TYPED_TEST(MailboxContract, WhenFullAMessageOfLowerPriorityIsRefusedAndReplacesNothing) {
  TypeParam mailbox(2);
  mailbox.put(0, 200);
  mailbox.put(1, 255);
  EXPECT_EQ(mailbox.put(2, 199), Put::kRefused);
  EXPECT_EQ(mailbox.replaced(), 0U);
  EXPECT_EQ(this->drain(mailbox), (Numbers{1, 0}));
}

// The rules in their simplest form: a sorted list, to which each queue is compared.
class Model {
 public:
  explicit Model(std::size_t places) : places_(places) {}
  Put put(std::uint32_t number, std::uint8_t priority) {
    Put outcome = Put::kTaken;
    if (waiting_.size() == places_) {
      // waiting_ is in order of arrival, so the first of the lowest priority is the oldest.
      const auto lowest = std::ranges::min_element(waiting_, {}, &Waiting::priority);
      if (lowest->priority > priority) return Put::kRefused;
      waiting_.erase(lowest);
      outcome = Put::kTakenForAnother;
    }
    waiting_.push_back({number, priority});
    return outcome;
  }
  std::optional<std::uint32_t> take() {
    if (waiting_.empty()) return std::nullopt;
    const auto highest = std::ranges::max_element(waiting_, {}, &Waiting::priority);
    const std::uint32_t number = highest->number;
    waiting_.erase(highest);
    return number;
  }

 private:
  struct Waiting {
    std::uint32_t number;
    std::uint8_t priority;
  };
  std::size_t places_;
  std::vector<Waiting> waiting_{};
};

TYPED_TEST(MailboxContract, BehavesLikeTheModelForRandomMessages) {
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const auto places = static_cast<std::uint32_t>(1 + random() % 20);
    const auto priorities = static_cast<std::uint32_t>(1 + random() % 6);
    TypeParam mailbox(places);
    Model model(places);
    for (std::uint32_t number = 0; number < 500; ++number) {
      if (random() % 3 != 0) {
        const auto priority = static_cast<std::uint8_t>(random() % priorities * 50);
        ASSERT_EQ(mailbox.put(number, priority), model.put(number, priority)) << "seed " << seed;
      } else {
        ASSERT_EQ(mailbox.take(), model.take()) << "seed " << seed << " at " << number;
      }
    }
    while (const auto expected = model.take()) ASSERT_EQ(mailbox.take(), expected) << seed;
    ASSERT_EQ(mailbox.take(), std::nullopt) << seed;
  }
}

}  // namespace mailbox_contract_test
}  // namespace tims
