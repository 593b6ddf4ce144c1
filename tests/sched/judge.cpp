// The invariants of every run, wherever threads were interrupted or crashed.
#include <algorithm>

#include "tests/sched/mailbox_fixture.h"
#include "tests/sched/weak_memory.h"

namespace tims::sched {

using shm::SendOutcome;
using shm::SlotState;
using shm::SlotWord;
using std::memory_order_relaxed;

namespace {

constexpr std::uint8_t kHighest = 255;

std::string text_of(const Message& message) {
  return "message " + std::to_string(message.number) + " of writer " +
         std::to_string(message.writer) + " (priority " + std::to_string(message.priority) + ")";
}

}  // namespace

void MailboxFixture::accuse(std::string what) {
  if (!accusation_) accusation_ = std::move(what);
}

SlotWord MailboxFixture::word_of(std::uint32_t index) const {
  return SlotWord::unpack(view_.slot(index).word.raw()->load(memory_order_relaxed));
}

bool MailboxFixture::still_readable(const Message& message) const {
  const SlotWord word = word_of(message.claim.index);
  return word.state == SlotState::kReadable && word.generation == message.claim.word.generation;
}

void MailboxFixture::look_for_room(Message& message) const {
  bool full = true;
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    const SlotWord word = word_of(i);
    const bool free = word.state == SlotState::kFree || word.state == SlotState::kAbandoned;
    const bool weak = word.state == SlotState::kReadable && word.priority <= message.priority;
    full = full && !free && !weak;
  }
  message.was_full = message.was_full || full;
}

void MailboxFixture::observe() {
  for (Message* message : claiming_) look_for_room(*message);
}

// Messages that the owner must find: commit() has returned, and they were neither taken nor
// replaced.
std::vector<const Message*> MailboxFixture::certainly_waiting() const {
  std::vector<const Message*> waiting;
  if (weak_ != nullptr) return waiting;
  for (const Message& message : messages_)
    if (message.committed != 0 && message.taken == 0 && still_readable(message))
      waiting.push_back(&message);
  return waiting;
}

// The message that this one replaced, if it is known.
const Message* MailboxFixture::replaced_by(const Message& message) const {
  const auto is_victim = [&message](const Message& other) {
    const std::uint32_t next = (other.claim.word.generation + 1) & SlotWord::kMask24;
    return other.has_slot() && other.claim.index == message.claim.index &&
           next == message.claim.word.generation;
  };
  if (message.claim_outcome != SendOutcome::kReplaced) return nullptr;
  const auto victim = std::ranges::find_if(messages_, is_victim);
  return victim == messages_.end() ? nullptr : &*victim;
}

void MailboxFixture::check_claim(const Message& message) {
  switch (message.claim_outcome) {
    case SendOutcome::kFull:
      if (!message.was_full && weak_ == nullptr)
        accuse(text_of(message) + " was refused as full, but the mailbox was never full");
      break;
    case SendOutcome::kReplaced:
      check_victim(message);
      break;
    case SendOutcome::kClosed:
      if (!message.had_closed)
        accuse(text_of(message) + " was refused as closed, but the mailbox is open");
      break;
    default:
      break;
  }
}

// The oldest message of the lowest priority must be replaced.
void MailboxFixture::check_victim(const Message& message) {
  const Message* victim = replaced_by(message);
  if (victim == nullptr) return;
  if (victim->priority > message.priority)
    accuse(text_of(*victim) + " was replaced by one of lower priority");
  for (const Message* other : certainly_waiting()) {
    if (other->committed >= message.begun) continue;
    if (other->priority < victim->priority)
      accuse(text_of(*victim) +
             " was replaced instead of one of lower priority: " + text_of(*other));
    if (other->priority == victim->priority && other->committed < victim->begun)
      accuse(text_of(*victim) + " was replaced instead of the older " + text_of(*other));
  }
}

// `waiting`: messages that were certainly available when take() was called, at the tick `begun`.
void MailboxFixture::check_taken(const Message& message, std::uint64_t begun,
                                 const std::vector<const Message*>& waiting) {
  if (message.taken != 0) accuse(text_of(message) + " was taken twice");
  if (!message.has_slot() || message.given_up) accuse(text_of(message) + " was never committed");
  for (const Message* other : waiting) {
    if (other == &message || !still_readable(*other)) continue;
    if (other->priority > message.priority)
      accuse(text_of(message) + " was taken before " + text_of(*other));
    if (other->priority == message.priority && other->committed < message.begun)
      accuse(text_of(message) + " overtook " + text_of(*other) + " at tick " +
             std::to_string(begun));
  }
}

void MailboxFixture::check_nothing_taken(const std::vector<const Message*>& waiting) {
  for (const Message* message : waiting)
    if (still_readable(*message)) accuse(text_of(*message) + " was waiting, but not found");
}

std::optional<std::string> MailboxFixture::judge(const Outcome& outcome) {
  if (outcome.endless) accuse("an endless loop");
  if (weak_ != nullptr && weak_->raced()) accuse("a message is written while it may be read");
  if (accusation_) return accusation_;
  check_sleep(outcome.stuck);
  for (std::uint32_t i = 0; i < 2 * view_.geometry().slots && receive(); ++i) {
  }
  check_order();
  check_losses(outcome.died);
  check_counters(outcome.died);
  if (!closed_) {
    check_slots_come_back();
    check_rings_are_well();
  }
  return accusation_;
}

void MailboxFixture::check_sleep(Threads stuck) {
  if (stuck != 0 && asleep_ && shm::waiting(receiver_->view()) > 0)
    accuse("the owner sleeps while a message waits");
}

// Arrival order is guaranteed when one message was committed before the other was begun.
void MailboxFixture::check_order() {
  for (const Message& early : messages_)
    for (const Message& late : messages_)
      if ((weak_ == nullptr || early.writer == late.writer) && early.priority == late.priority &&
          early.taken != 0 && late.taken != 0 && early.committed != 0 &&
          early.committed < late.begun && late.taken < early.taken)
        accuse(text_of(late) + " overtook " + text_of(early));
}

// Every message is taken, or replaced by one whose outcome reports it; a sender that crashes while
// claiming reports nothing.
void MailboxFixture::check_losses(bool died) {
  std::size_t unexplained = 0;
  for (const Message& message : messages_) {
    const auto is_successor = [&](const Message& m) { return replaced_by(m) == &message; };
    const bool replaced = std::ranges::any_of(messages_, is_successor);
    if (message.taken != 0 && replaced) accuse(text_of(message) + " was taken and replaced");
    if (message.taken != 0 && message.outcome == SendOutcome::kReclaimed)
      accuse(text_of(message) + " was taken, but commit() returned kReclaimed");
    if (message.committed != 0 && message.taken == 0 && !replaced) ++unexplained;
  }
  const auto is_open = [](const Message& m) { return m.claimed == 0; };
  const bool died_claiming = died && std::ranges::any_of(messages_, is_open);
  if (unexplained > (died_claiming ? 1 : 0)) accuse("a message is lost");
}

void MailboxFixture::check_counters(bool died) {
  const auto check = [this](const char* name, std::uint64_t is, std::uint64_t should,
                            std::uint64_t unsure) {
    if (is < should || is > should + unsure)
      accuse(std::string(name) + " counts " + std::to_string(is) + " instead of " +
             std::to_string(should));
  };
  const auto count = [this](SendOutcome outcome) {
    return static_cast<std::uint64_t>(
        std::ranges::count(messages_, outcome, &Message::claim_outcome) -
        std::ranges::count_if(messages_, [outcome](const Message& m) {
          return m.claimed == 0 && m.claim_outcome == outcome;
        }));
  };
  const shm::MailboxHeader& header = view_.header();
  const std::uint64_t unsure = died ? 1 : 0;
  check("replaced", header.replaced.raw()->load(),
        count(SendOutcome::kReplaced) + unrecorded_replacements_, unsure);
  check("refused", header.refused.raw()->load(), count(SendOutcome::kFull), unsure);
  check("received", header.received.raw()->load(), takes_, 0);
}

void MailboxFixture::check_slots_come_back() {
  shm::Sender sender(view_, shm::SlotWord::kMask24);
  const std::uint32_t slots = view_.geometry().slots;
  std::vector<shm::Claim> claims(slots);
  for (shm::Claim& claim : claims)
    if (sender.claim(kHeaderSize, 0, claim) != SendOutcome::kOk) return accuse("a slot is lost");
  shm::Claim none;
  if (sender.claim(kHeaderSize, kHighest, none) != SendOutcome::kFull)
    accuse("more slots than there are");
  for (const shm::Claim& claim : claims) sender.give_up(claim);
  if (receiver_->take()) accuse("a message that was never sent");
}

// No run may slow the mailbox down permanently: while the owner is awake, neither a sender nor the
// owner scans all slots.
void MailboxFixture::check_rings_are_well() {
  const shm::MailboxHeader& header = view_.header();
  const std::uint64_t rescans = header.rescans.raw()->load();
  const std::uint64_t free_head = header.free_head.raw()->load();
  const std::uint32_t rounds = 2 * view_.geometry().slots;
  for (std::uint32_t i = 0; i < rounds; ++i) {
    advance(1);
    if (receiver_->take()) accuse("one message came twice");
  }
  if (header.rescans.raw()->load() != rescans) accuse("the arrival ring does not work any more");
  if (header.free_head.raw()->load() < free_head + rounds)
    accuse("the free ring does not work any more");
}

}  // namespace tims::sched
