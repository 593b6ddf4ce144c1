#include "client/mailbox.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <poll.h>
#include <sched.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tims/mailbox.h"

namespace tims {

namespace {

thread_local WaitObserver* observer_of_this_thread = nullptr;

shm::MailboxView view_of(const OwnSegment& segment, std::size_t index) {
  // This process has laid out the memory itself: opening it cannot fail.
  return *shm::MailboxView::open(segment.mapping.bytes(), segment.mailboxes[index].offset);
}

Result<MessageView> copy_out(MailboxCore& core, Result<shm::Taken> taken,
                             std::span<std::byte> buffer) {
  if (!taken) return taken.error();
  if (taken->body.size() > buffer.size()) {
    core.put_back(*taken);
    return Errc::kBufferTooSmall;
  }
  const auto to = buffer.first(taken->body.size());
  if (!to.empty()) std::memcpy(to.data(), taken->body.data(), to.size());
  core.release(taken->hint);
  return MessageView{taken->header, to};
}

}  // namespace

// --- Observation of waits

void set_wait_observer(WaitObserver* observer) { observer_of_this_thread = observer; }
WaitObserver* wait_observer() { return observer_of_this_thread; }

// --- MailboxCore

MailboxCore::MailboxCore(std::shared_ptr<SessionCore> session, std::shared_ptr<OwnSegment> segment,
                         std::size_t index, const MailboxOptions& options)
    : session_(std::move(session)),
      segment_(std::move(segment)),
      address_(segment_->mailboxes[index].address),
      body_max_(options.body_max),
      priority_(options.priority),
      spin_(options.spin),
      event_fd_(segment_->mailboxes[index].wake.woken.get()),
      waker_(segment_->mailboxes[index].wake.waker.get()),
      receiver_(view_of(*segment_, index)) {}

void MailboxCore::close() {
  if (closed_.exchange(true)) return;
  receiver_.close();
  wake_own_readers();
  session_->close(*segment_, address_);
}

void MailboxCore::wake_own_readers() {
  if (event_fd_ >= 0) os::wake(waker_);
  os::futex_clear_and_wake(*receiver_.view().header().sleep.raw());
}

Result<shm::Taken> MailboxCore::take_before(Time deadline) {
  std::unique_lock seat(seat_, std::try_to_lock);
  if (!seat.owns_lock() && deadline == kNever) seat.lock();
  if (!seat.owns_lock() && !seat.try_lock_for(deadline - os::now())) return Errc::kTimeout;
  if (auto taken = receiver_.take()) return *taken;
  const Waiting waiting;
  for (;;) {
    if (auto taken = receiver_.take()) return *taken;
    if (closed_.load(std::memory_order_acquire)) return Errc::kClosed;
    if (deadline != kNever && os::now() >= deadline) return Errc::kTimeout;
    if (auto taken = spin(deadline)) return *taken;
    sleep(deadline);
  }
}

std::optional<shm::Taken> MailboxCore::spin(Time deadline) {
  if (spin_ <= Duration::zero()) return std::nullopt;
  const Time end = std::min(deadline, os::deadline_after(spin_));
  do {
    ::sched_yield();
    if (auto taken = receiver_.take()) return taken;
  } while (os::now() < end && !closed_.load(std::memory_order_acquire));
  return std::nullopt;
}

void MailboxCore::sleep(Time deadline) {
  const std::uint32_t armed = receiver_.arm();
  if (receiver_.nothing_came() && !closed_.load(std::memory_order_seq_cst)) {
    if (event_fd_ < 0) {
      os::futex_wait(*receiver_.view().header().sleep.raw(), armed, deadline);
    } else {
      (void)os::is_ready(event_fd_, POLLIN, deadline);
      os::drain_wakes(event_fd_);
    }
  }
  receiver_.disarm();
}

// The caller returns to its event loop: the next message must make the descriptor readable.
Result<shm::Taken> MailboxCore::arm_event_fd() {
  os::drain_wakes(event_fd_);
  receiver_.arm();
  if (receiver_.nothing_came()) return Errc::kEmpty;
  receiver_.disarm();
  if (auto taken = receiver_.take()) return *taken;
  os::wake(waker_);  // a hint without a message: make the caller check again
  return Errc::kEmpty;
}

void MailboxCore::put_back(const shm::Taken& taken) {
  const std::lock_guard seat(seat_);
  receiver_.put_back(taken);
}

std::size_t MailboxCore::clean() {
  const std::lock_guard seat(seat_);
  return receiver_.clean();
}

// Waits for room in an uplink: a running router empties it within one turn of its loop.
shm::SendOutcome MailboxCore::wait_for_room(Draft& draft) {
  constexpr Duration kPatience = std::chrono::milliseconds(200);
  constexpr timespec kMoment{0, 20'000};
  auto outcome = shm::SendOutcome::kFull;
  for (const Time end = os::deadline_after(kPatience); os::now() < end;) {
    ::nanosleep(&kMoment, nullptr);
    outcome = draft.target->sender.claim(draft.header.length, draft.header.priority, draft.claim);
    if (outcome != shm::SendOutcome::kFull) break;
  }
  return outcome;
}

Error MailboxCore::not_sent(shm::SendOutcome outcome, Address dest) const {
  switch (outcome) {
    case shm::SendOutcome::kFull:
      return Errc::kFull;
    case shm::SendOutcome::kTooBig:
      return Errc::kTooBig;
    case shm::SendOutcome::kReclaimed:
      return Errc::kReclaimed;
    default:
      return {Errc::kNoMailbox, dest.to_string(session_->welcome().widths)};
  }
}

MailboxCounters MailboxCore::counters() const {
  const shm::Counters c = shm::counters(receiver_.view());
  return {.received = c.received,
          .waiting = shm::waiting(receiver_.view()),
          .replaced = c.replaced,
          .refused = c.refused,
          .too_big = c.too_big,
          .reclaimed = c.reclaimed};
}

// --- PeekGuard and Loan

PeekGuard& PeekGuard::operator=(PeekGuard&& other) noexcept {
  std::swap(core_, other.core_);
  std::swap(slot_, other.slot_);
  std::swap(header_, other.header_);
  std::swap(body_, other.body_);
  return *this;
}

void PeekGuard::release() {
  if (core_ == nullptr) return;
  core_->release(shm::Hint::unpack(slot_));
  core_ = nullptr;
}

Loan::Loan(Loan&& other) noexcept
    : core_(std::exchange(other.core_, nullptr)),
      target_(other.target_),
      word_(other.word_),
      index_(other.index_),
      header_(other.header_),
      body_(other.body_) {}

Loan& Loan::operator=(Loan&& other) noexcept {
  std::swap(core_, other.core_);
  std::swap(target_, other.target_);
  std::swap(word_, other.word_);
  std::swap(index_, other.index_);
  std::swap(header_, other.header_);
  std::swap(body_, other.body_);
  return *this;
}

Loan::~Loan() {
  if (core_ != nullptr)
    target_->sender.give_up({.index = index_, .word = shm::SlotWord::unpack(word_)});
}

Result<void> Loan::send() {
  if (core_ == nullptr) return Error(Errc::kInvalidArgument, "the loan was sent already");
  const shm::Claim claim{.index = index_,
                         .word = shm::SlotWord::unpack(word_),
                         .header = target_->sender.view().message_header(index_)};
  body_ = {};
  return std::exchange(core_, nullptr)->commit({target_, claim, header_});
}

// --- Mailbox

Mailbox::Mailbox(std::shared_ptr<MailboxCore> core) : core_(std::move(core)) {}
Mailbox::Mailbox(Mailbox&&) noexcept = default;

Mailbox& Mailbox::operator=(Mailbox&& other) noexcept {
  std::swap(core_, other.core_);
  return *this;
}

Mailbox::~Mailbox() {
  if (core_ != nullptr) core_->close();
}

Address Mailbox::address() const { return core_->address(); }
std::uint32_t Mailbox::body_max() const { return core_->body_max(); }
AddressWidths Mailbox::address_widths() const { return core_->address_widths(); }
MailboxCounters Mailbox::counters() const { return core_->counters(); }
int Mailbox::event_fd() const { return core_->event_fd(); }
std::size_t Mailbox::clean() { return core_->clean(); }
Result<void> Mailbox::flush(Duration timeout) { return core_->flush(os::deadline_after(timeout)); }

Result<void> Mailbox::send(const Envelope& envelope, std::span<const std::byte> body) {
  return send(envelope, std::span(&body, 1));
}

Result<void> Mailbox::send(const Envelope& envelope,
                           std::span<const std::span<const std::byte>> pieces) {
  std::size_t size = 0;
  for (const auto& piece : pieces) size += piece.size();
  MailboxCore::Draft draft;
  if (auto claimed = core_->claim(envelope, size, draft); !claimed) return claimed;
  std::byte* to = draft.claim.body;
  for (const auto& piece : pieces) {
    if (!piece.empty()) std::memcpy(to, piece.data(), piece.size());
    to += piece.size();
  }
  return core_->commit(draft);
}

Result<void> Mailbox::try_send(const Envelope& envelope, std::span<const std::byte> body) {
  MailboxCore::Draft draft;
  if (auto claimed = core_->try_claim(envelope, body.size(), draft); !claimed) return claimed;
  if (!body.empty()) std::memcpy(draft.claim.body, body.data(), body.size());
  return core_->commit(draft);
}

Result<void> Mailbox::reply(const Header& request, std::int8_t type,
                            std::span<const std::byte> body) {
  return send(
      {.dest = request.src, .type = type, .priority = request.priority, .seq_nr = request.seq_nr},
      body);
}

Result<Loan> Mailbox::loan(const Envelope& envelope, std::uint32_t body_size) {
  MailboxCore::Draft draft;
  if (auto claimed = core_->claim(envelope, body_size, draft); !claimed) return claimed.error();
  Loan loan;
  loan.core_ = core_.get();
  loan.target_ = draft.target;
  loan.word_ = draft.claim.word.pack();
  loan.index_ = draft.claim.index;
  loan.header_ = draft.header;
  loan.body_ = {draft.claim.body, body_size};
  return loan;
}

Result<MessageView> Mailbox::receive(std::span<std::byte> buffer) {
  return copy_out(*core_, core_->take_before(kNever), buffer);
}
Result<MessageView> Mailbox::receive_for(std::span<std::byte> buffer, Duration timeout) {
  return copy_out(*core_, core_->take_before(os::deadline_after(timeout)), buffer);
}
Result<MessageView> Mailbox::try_receive(std::span<std::byte> buffer) {
  return copy_out(*core_, core_->try_take(), buffer);
}

Result<PeekGuard> Mailbox::guard(Result<shm::Taken> taken) {
  if (!taken) return taken.error();
  PeekGuard guard;
  guard.core_ = core_.get();
  guard.slot_ = taken->hint.pack();
  guard.header_ = taken->header;
  guard.body_ = taken->body;
  return guard;
}

Result<PeekGuard> Mailbox::peek() { return guard(core_->take_before(kNever)); }
Result<PeekGuard> Mailbox::peek_for(Duration timeout) {
  return guard(core_->take_before(os::deadline_after(timeout)));
}
Result<PeekGuard> Mailbox::try_peek() { return guard(core_->try_take()); }

}  // namespace tims
