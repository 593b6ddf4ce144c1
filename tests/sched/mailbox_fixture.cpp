#include "tests/sched/mailbox_fixture.h"

#include <cstring>
#include <new>

#include "shm/layout.h"
#include "wire/header.h"

namespace tims::sched {

using std::memory_order_relaxed;

namespace {

constexpr std::uint32_t kLength = kHeaderSize + MailboxFixture::kBodyBytes;
constexpr std::size_t kHalf = MailboxFixture::kBodyBytes / 2;
constexpr std::uint32_t kMessagesMax =
    512;  // per run; reserved, because their addresses must not change
constexpr std::uint32_t kStageHand = 1;  // the writer that prepares the mailbox

std::byte pattern(std::uint32_t number, std::size_t at) {
  return static_cast<std::byte>(std::size_t{number} * 37 + at * 11 + 5);
}

}  // namespace

void MailboxFixture::Releaser::operator()(std::byte* memory) const {
  ::operator delete(memory, std::align_val_t{shm::kMailboxAlign});
}

void MailboxFixture::reset(std::uint32_t slots) {
  const std::size_t bytes = shm::Geometry::of(slots, kLength).bytes;
  if (bytes_ != bytes) {
    memory_.reset(
        static_cast<std::byte*>(::operator new(bytes, std::align_val_t{shm::kMailboxAlign})));
    bytes_ = bytes;
    messages_.reserve(kMessagesMax);
  }
  std::memset(memory_.get(), 0, bytes);
  view_ = shm::MailboxView::create({memory_.get(), bytes}, 0,
                                   {.address = Address(1), .slots = slots, .message_max = kLength});
  receiver_.emplace(view_);
  senders_.clear();
  messages_.clear();
  claiming_.clear();
  ticks_ = 0;
  takes_ = 0;
  unrecorded_replacements_ = 0;
  closed_ = false;
  asleep_ = false;
  accusation_.reset();
}

shm::Sender& MailboxFixture::sender_of(std::uint32_t writer) {
  while (senders_.size() < writer)
    senders_.emplace_back(view_, static_cast<std::uint32_t>(senders_.size() + 1));
  return senders_[writer - 1];
}

Message& MailboxFixture::begin(std::uint32_t writer, std::uint8_t priority) {
  if (messages_.size() == kMessagesMax) std::abort();
  Message& message = messages_.emplace_back();
  message.number = static_cast<std::uint32_t>(messages_.size());
  message.priority = priority;
  message.writer = writer;
  message.begun = ++ticks_;
  return message;
}

bool MailboxFixture::claim(shm::Sender& sender, Message& message) {
  claiming_.push_back(&message);
  look_for_room(message);
  message.claim_outcome = message.outcome = sender.claim(kLength, message.priority, message.claim);
  std::erase(claiming_, &message);
  message.claimed = ++ticks_;
  message.had_closed = closed_;
  check_claim(message);
  return shm::taken(message.claim_outcome);
}

void MailboxFixture::send(std::uint32_t writer, std::uint8_t priority) {
  shm::Sender& sender = sender_of(writer);
  Message& message = begin(writer, priority);
  if (!claim(sender, message)) return;
  write(message);
  message.outcome = sender.commit(message.claim);
  if (message.outcome != shm::SendOutcome::kOk) return;
  message.committed = ++ticks_;
  wake(sender);
}

// One step, as in the kernel for os::futex_clear_and_wake().
void MailboxFixture::wake(shm::Sender& sender) {
  if (sender.sleeper() != 0) view_.header().sleep.fetch_and(~1U, std::memory_order_seq_cst);
}

void MailboxFixture::loan_and_give_up(std::uint32_t writer) {
  shm::Sender& sender = sender_of(writer);
  Message& message = begin(writer, 0);
  if (!claim(sender, message)) return;
  message.given_up = true;
  sender.give_up(message.claim);
}

// In two parts, so that the pattern reveals a second writer in the slot or a reader that is too
// early.
void MailboxFixture::write(const Message& message) {
  std::byte* bytes = message.claim.header;
  std::byte* body = message.claim.body;
  write_bytes(bytes);
  const Header header{
      .priority = message.priority, .dest = Address(message.number), .length = kLength};
  wire::encode_header(header, wire::HeaderBytes(bytes, kHeaderSize));
  for (std::size_t i = 0; i < kHalf; ++i) body[i] = pattern(message.number, i);
  write_bytes(bytes);
  for (std::size_t i = kHalf; i < kBodyBytes; ++i) body[i] = pattern(message.number, i);
}

// The number of the message if it is complete.
std::optional<std::uint32_t> MailboxFixture::read(const shm::Taken& taken) {
  const std::uint32_t number = taken.header.dest.raw();
  const std::byte* bytes = taken.body.data() - kHeaderSize;
  bool whole = taken.body.size() == kBodyBytes && number >= 1 && number <= messages_.size();
  for (std::size_t i = 0; whole && i < kBodyBytes; ++i) {
    if (i % kHalf == 0) read_bytes(bytes);
    whole = taken.body[i] == pattern(number, i);
  }
  if (whole && messages_[number - 1].priority == taken.header.priority) return number;
  accuse("a torn message, perhaps number " + std::to_string(number));
  return std::nullopt;
}

std::optional<shm::Taken> MailboxFixture::peek() {
  const std::uint64_t begun = ++ticks_;
  const std::vector<const Message*> waiting = certainly_waiting();
  const std::optional<shm::Taken> taken = receiver_->take();
  if (!taken) {
    check_nothing_taken(waiting);
    return std::nullopt;
  }
  ++takes_;
  const std::optional<std::uint32_t> number = read(*taken);
  if (!number) return taken;
  Message& message = messages_[*number - 1];
  check_taken(message, begun, waiting);
  message.taken = ++ticks_;
  return taken;
}

void MailboxFixture::release(const shm::Taken& taken) { receiver_->release(taken.hint); }

bool MailboxFixture::receive() {
  const std::optional<shm::Taken> taken = peek();
  if (taken) release(*taken);
  return taken.has_value();
}

void MailboxFixture::peek_and_put_back() {
  const std::optional<shm::Taken> taken = peek();
  if (!taken) return;
  messages_[taken->header.dest.raw() - 1].taken = 0;
  --takes_;
  receiver_->put_back(*taken);
}

void MailboxFixture::receive_or_sleep() {
  while (!receive()) {
    const std::uint32_t armed = receiver_->arm();
    if (receiver_->nothing_came()) {
      asleep_ = true;
      const auto* word = view_.header().sleep.raw();
      wait_until(&view_.header().sleep, [word, armed] { return word->load() != armed; });
      asleep_ = false;
    }
    receiver_->disarm();
    if (receiver_->closed()) return;
  }
}

void MailboxFixture::close() {
  closed_ = true;
  receiver_->close();
}

void MailboxFixture::reclaim_after_death(std::uint32_t writer) {
  const bool& died = scheduler_.died();
  wait_until(&died, [&died] { return died; });
  learn_everything();
  reclaim_slots_of(writer);
}

void MailboxFixture::reclaim_slots_of(std::uint32_t writer) {
  shm::reclaim(view_, [writer](std::uint32_t owner) { return owner == writer; });
  wake(sender_of(kStageHand));
}

void MailboxFixture::send_unrecorded() {
  shm::Sender& sender = sender_of(kStageHand);
  shm::Claim claim;
  sender.claim(kLength, 0, claim);
  wire::encode_header({.length = kLength}, wire::HeaderBytes(claim.header, kHeaderSize));
  sender.commit(claim);
}

void MailboxFixture::advance(std::uint32_t messages) {
  for (std::uint32_t i = 0; i < messages; ++i) {
    send_unrecorded();
    const std::optional<shm::Taken> taken = receiver_->take();
    if (!taken) return accuse("a message was sent, but not found");
    receiver_->release(taken->hint);
    ++takes_;
  }
}

void MailboxFixture::age_slots(std::uint32_t generation) {
  for (std::uint32_t i = 0; i < view_.geometry().slots; ++i) {
    view_.slot(i).word.store(shm::SlotWord{.generation = generation}.pack(), memory_order_relaxed);
    shm::Hint hint = shm::Hint::unpack(view_.free(i).load(memory_order_relaxed));
    hint.generation = generation;
    view_.free(i).store(hint.pack(), memory_order_relaxed);
  }
}

// The last messages are recorded, because they are still in the mailbox when the run begins.
void MailboxFixture::overrun(std::uint32_t messages) {
  const std::uint32_t slots = view_.geometry().slots;
  for (std::uint32_t i = 0; i + slots < messages; ++i) {
    send_unrecorded();
    if (i >= slots) ++unrecorded_replacements_;
  }
  for (std::uint32_t i = 0; i < slots; ++i) send(kStageHand);
}

std::string MailboxFixture::name_of(Operation operation) const {
  const auto at = reinterpret_cast<std::uintptr_t>(operation.where);
  const auto base = reinterpret_cast<std::uintptr_t>(memory_.get());
  const std::string what = operation.waits                     ? "waits for "
                           : operation.access == Access::kRead ? "reads "
                                                               : "writes ";
  const shm::Geometry& g = view_.geometry();
  const std::size_t offset = at - base;
  if (operation.where == nullptr) return "begins";
  if (at == reinterpret_cast<std::uintptr_t>(&scheduler_.died())) return what + "the crash";
  if (at < base || offset >= bytes_) return what + "private memory";
  if (offset < g.arrival_at) return what + "header + " + std::to_string(offset);
  if (offset < g.free_at) return what + "arrival " + std::to_string((offset - g.arrival_at) / 8);
  if (offset < g.slots_at) return what + "free " + std::to_string((offset - g.free_at) / 8);
  const std::size_t in_slot = (offset - g.slots_at) % g.stride;
  return what + "slot " + std::to_string((offset - g.slots_at) / g.stride) +
         (in_slot == 0   ? " state"
          : in_slot == 8 ? " stamp"
                         : " message");
}

}  // namespace tims::sched
