#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <new>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "wire/header.h"

namespace tims::shm {
namespace mailbox_test {

// A mailbox in private memory, with helpers for the tests below.
class MailboxTest : public testing::Test {
 protected:
  void make(std::uint32_t slots, std::uint32_t body_max = 64, std::uint32_t long_places = 0) {
    const std::uint32_t message_max = body_max + kHeaderSize;
    bytes_ = Geometry::of(slots, message_max, long_places).bytes;
    memory_ = static_cast<std::byte*>(::operator new(bytes_, std::align_val_t{128}));
    std::memset(memory_, 0, bytes_);
    view_ = MailboxView::create(memory(), 0,
                                {.address = Address(7),
                                 .slots = slots,
                                 .message_max = message_max,
                                 .long_places = long_places});
    receiver_.emplace(view_);
  }
  void TearDown() override { ::operator delete(memory_, std::align_val_t{128}); }

  std::span<std::byte> memory() { return {memory_, bytes_}; }

  SendOutcome send(Sender& sender, const std::string& body, std::uint8_t priority = 0) {
    Claim claim;
    const auto length = static_cast<std::uint32_t>(kHeaderSize + body.size());
    const SendOutcome outcome = sender.claim(length, priority, claim);
    if (!taken(outcome)) return outcome;
    write(claim, body, priority);
    const SendOutcome committed = sender.commit(claim);
    return committed == SendOutcome::kOk ? outcome : committed;
  }
  static void write(const Claim& claim, const std::string& body, std::uint8_t priority) {
    const Header header{.priority = priority,
                        .length = static_cast<std::uint32_t>(kHeaderSize + body.size())};
    wire::encode_header(header, wire::HeaderBytes(claim.header, kHeaderSize));
    std::memcpy(claim.body, body.data(), body.size());
  }
  std::string receive() {
    const auto taken = receiver_->take();
    if (!taken) return "(empty)";
    std::string body(reinterpret_cast<const char*>(taken->body.data()), taken->body.size());
    receiver_->release(taken->hint);
    return body;
  }

  MailboxView view_;
  std::optional<Receiver> receiver_;

 private:
  std::byte* memory_ = nullptr;
  std::size_t bytes_ = 0;
};

TEST_F(MailboxTest, FullReplacesTheOldestOfTheLowestPriority) {
  make(3);
  Sender sender(view_, 1);
  send(sender, "a5", 5);
  send(sender, "b3", 3);
  send(sender, "c3", 3);
  EXPECT_EQ(send(sender, "d3", 3), SendOutcome::kReplaced);  // b3 goes
  EXPECT_EQ(send(sender, "e2", 2), SendOutcome::kFull);      // all more important
  EXPECT_EQ(send(sender, "f255", 255), SendOutcome::kReplaced);
  for (const char* expected : {"f255", "a5", "d3", "(empty)"}) EXPECT_EQ(receive(), expected);
  EXPECT_EQ(view_.header().replaced.load(std::memory_order_relaxed), 2U);
  EXPECT_EQ(view_.header().refused.load(std::memory_order_relaxed), 1U);
}

// In a mailbox of many slots the sender remembers the next slots to replace: the rule is the same.
TEST_F(MailboxTest, AFullMailboxOfManySlotsKeepsToTheRule) {
  constexpr std::uint32_t kSlots = 1024;
  make(kSlots);
  Sender one(view_, 1);
  Sender other(view_, 2);
  std::map<int, std::deque<std::string>> model;  // by priority
  std::uint32_t held = 0;
  std::mt19937 random(1);
  for (int i = 0; i < 60'000; ++i) {
    const int phase = i / 10'000;
    const int priority = phase % 2 == 0 ? 3 : static_cast<int>(random() % 8);
    const std::string body = std::to_string(i);
    const bool full = held == kSlots;
    auto lowest = std::ranges::find_if(model, [](const auto& p) { return !p.second.empty(); });
    const bool takes = !full || lowest->first <= priority;
    const auto outcome = send(random() % 50 == 0 && phase > 2 ? other : one, body,
                              static_cast<std::uint8_t>(priority));
    ASSERT_EQ(taken(outcome), takes) << i;
    ASSERT_EQ(outcome == SendOutcome::kReplaced, full && takes) << i;
    if (full && takes) lowest->second.pop_front();
    if (takes) model[priority].push_back(body);
    held += !full && takes ? 1 : 0;
    for (std::uint32_t n = random() % 300 == 0 ? 5 : 0; n > 0 && held > 0; --n, --held) {
      auto first = std::find_if(model.rbegin(), model.rend(),
                                [](const auto& p) { return !p.second.empty(); });
      ASSERT_EQ(receive(), first->second.front()) << i;
      first->second.pop_front();
    }
  }
  for (auto p = model.rbegin(); p != model.rend(); ++p)
    for (const std::string& body : p->second) ASSERT_EQ(receive(), body);
  EXPECT_EQ(receive(), "(empty)");
}

TEST_F(MailboxTest, OwnerThatSleepsThroughManyLapsGetsTheNewestInOrder) {
  make(4);
  Sender sender(view_, 1);
  for (int i = 0; i < 5000; ++i) send(sender, std::to_string(i));
  for (const char* expected : {"4996", "4997", "4998", "4999", "(empty)"})
    EXPECT_EQ(receive(), expected);
  send(sender, "next");
  EXPECT_EQ(receive(), "next");
}

TEST_F(MailboxTest, BusyWithImportantMessagesTheOwnerKeepsTheRestBounded) {
  make(4);
  Sender sender(view_, 1);
  send(sender, "low", 1);
  for (int i = 0; i < 5000; ++i) {
    send(sender, "x", 0);
    send(sender, "important", 9);
    EXPECT_EQ(receive(), "important");
  }
  EXPECT_EQ(receive(), "low");
}

TEST_F(MailboxTest, SizesAtTheLimit) {
  make(2, 10);
  Sender sender(view_, 1);
  EXPECT_EQ(send(sender, std::string(9, 'x')), SendOutcome::kOk);
  EXPECT_EQ(send(sender, std::string(10, 'x')), SendOutcome::kOk);
  EXPECT_EQ(send(sender, std::string(11, 'x')), SendOutcome::kTooBig);
  EXPECT_EQ(view_.header().too_big.load(std::memory_order_relaxed), 1U);
  EXPECT_EQ(receive().size(), 9U);
  EXPECT_EQ(receive().size(), 10U);
}

TEST_F(MailboxTest, ShortAndLongBodiesOfOneMailbox) {
  make(3, 10'000);
  Sender sender(view_, 1);
  const std::size_t short_max = view_.geometry().short_max;
  for (int turn = 0; turn < 4; ++turn) {
    const std::vector<std::string> bodies{
        std::string(short_max, 'a'), std::string(short_max + 1, 'b'), std::string(10'000, 'c')};
    for (const std::string& body : bodies) ASSERT_EQ(send(sender, body), SendOutcome::kOk);
    for (const std::string& body : bodies) EXPECT_EQ(receive(), body);
  }
}

TEST_F(MailboxTest, FewPlacesForLongBodies) {
  make(8, 10'000, 2);
  Sender sender(view_, 1);
  const auto body = [](char c) { return std::string(10'000, c); };
  for (char c = 'a'; c < 'z'; ++c) {
    ASSERT_EQ(send(sender, body(c)), SendOutcome::kOk);
    ASSERT_EQ(send(sender, "short"), SendOutcome::kOk);
    ASSERT_EQ(send(sender, body('z')), SendOutcome::kOk);
    EXPECT_EQ(send(sender, body('!')), SendOutcome::kFull);  // the third one
    EXPECT_EQ(send(sender, "short too"), SendOutcome::kOk);
    EXPECT_EQ(receive(), body(c));
    EXPECT_EQ(receive(), "short");
    EXPECT_EQ(receive(), body('z'));
    EXPECT_EQ(receive(), "short too");
    EXPECT_EQ(receive(), "(empty)");
  }
}

TEST_F(MailboxTest, PlacesOfSendersThatGiveUpOrDieComeBack) {
  make(4, 10'000, 1);
  Sender sender(view_, 5);
  Claim claim;
  ASSERT_EQ(sender.claim(9000, 0, claim), SendOutcome::kOk);
  sender.give_up(claim);
  EXPECT_EQ(receive(), "(empty)");
  ASSERT_EQ(sender.claim(9000, 0, claim), SendOutcome::kOk);
  reclaim(view_, [](std::uint32_t writer) { return writer == 5; });
  EXPECT_EQ(receive(), "(empty)");
  EXPECT_EQ(send(sender, std::string(9000, 'x')), SendOutcome::kOk);
}

TEST_F(MailboxTest, ALongBodyInNoPlaceIsNonsense) {
  make(2, 10'000);
  Sender sender(view_, 1);
  ASSERT_EQ(send(sender, std::string(9000, 'x')), SendOutcome::kOk);
  const std::uint32_t place = 2;
  std::memcpy(view_.short_body(0), &place, sizeof place);
  EXPECT_EQ(receive(), "(empty)");
  EXPECT_EQ(view_.header().reclaimed.load(std::memory_order_relaxed), 1U);
}

TEST_F(MailboxTest, PeekedSlotsAreNeverReplaced) {
  make(1);
  Sender sender(view_, 1);
  send(sender, "held");
  const auto held = receiver_->take();
  ASSERT_TRUE(held);
  EXPECT_EQ(send(sender, "other", 255), SendOutcome::kFull);
  receiver_->release(held->hint);
  EXPECT_EQ(send(sender, "other"), SendOutcome::kOk);
  EXPECT_EQ(receive(), "other");
}

TEST_F(MailboxTest, PutBackIsFirstAgain) {
  make(4);
  Sender sender(view_, 1);
  send(sender, "one");
  send(sender, "two");
  const auto taken = receiver_->take();
  receiver_->put_back(*taken);
  EXPECT_EQ(receive(), "one");
  EXPECT_EQ(receive(), "two");
}

TEST_F(MailboxTest, DeadWritersSlotsComeBack) {
  make(2);
  Sender dead(view_, 5);
  Sender alive(view_, 6);
  Claim lost;
  ASSERT_EQ(dead.claim(20, 0, lost), SendOutcome::kOk);
  ASSERT_EQ(dead.claim(20, 0, lost), SendOutcome::kOk);
  EXPECT_EQ(send(alive, "no room"), SendOutcome::kFull);
  EXPECT_EQ(reclaim(view_, [](std::uint32_t writer) { return writer == 5; }), 2U);
  EXPECT_EQ(send(alive, "room"), SendOutcome::kOk);
  EXPECT_EQ(dead.commit(lost), SendOutcome::kReclaimed);
  EXPECT_EQ(receive(), "room");
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(send(alive, "a"), SendOutcome::kOk);
    EXPECT_EQ(send(alive, "b"), SendOutcome::kOk);
    EXPECT_EQ(receive(), "a");
    EXPECT_EQ(receive(), "b");
  }
}

TEST_F(MailboxTest, GivenUpLoansComeBack) {
  make(1);
  Sender sender(view_, 1);
  for (int i = 0; i < 100; ++i) {
    Claim claim;
    ASSERT_EQ(sender.claim(20, 0, claim), SendOutcome::kOk);
    sender.give_up(claim);
    EXPECT_EQ(receive(), "(empty)");
  }
}

TEST_F(MailboxTest, ClosedMailboxSaysSo) {
  make(1);
  Sender sender(view_, 1);
  receiver_->close();
  EXPECT_EQ(send(sender, "x"), SendOutcome::kClosed);
}

TEST_F(MailboxTest, AnOwnerRestsWhenAllIsTakenClosedOrNot) {
  make(4);
  Sender sender(view_, 1);
  EXPECT_TRUE(receiver_->rest());
  send(sender, "a");
  EXPECT_FALSE(receiver_->rest());
  EXPECT_EQ(receive(), "a");
  receiver_->close();
  EXPECT_TRUE(receiver_->nothing_came());
  EXPECT_TRUE(receiver_->rest());
}

TEST_F(MailboxTest, CleanThrowsAwayWhatWaits) {
  make(4);
  Sender sender(view_, 1);
  send(sender, "held");
  const auto held = receiver_->take();
  send(sender, "a");
  send(sender, "b");
  EXPECT_EQ(receiver_->clean(), 2U);
  EXPECT_EQ(receive(), "(empty)");
  receiver_->release(held->hint);
}

TEST_F(MailboxTest, ArmedOwnerIsWokenByTheNextMessage) {
  make(4);
  Sender sender(view_, 1);
  EXPECT_EQ(sender.sleeper(), 0U);
  const std::uint32_t armed = receiver_->arm();
  EXPECT_TRUE(receiver_->nothing_came());
  send(sender, "x");
  EXPECT_FALSE(receiver_->nothing_came());
  EXPECT_EQ(sender.sleeper(), armed);
  receiver_->disarm();
  EXPECT_EQ(sender.sleeper(), 0U);
}

}  // namespace mailbox_test
}  // namespace tims::shm
