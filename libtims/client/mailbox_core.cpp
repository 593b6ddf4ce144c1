#include "client/mailbox_core.h"

#include <algorithm>

#include <poll.h>
#include <sched.h>

#include "os/clock.h"
#include "os/wakeup.h"

namespace tims {

namespace {

shm::MailboxView view_of(const OwnSegment& segment, std::size_t index) {
  // Our own memory, laid out a moment ago: it opens.
  return *shm::MailboxView::open(segment.mapping.bytes(), segment.mailboxes[index].offset);
}

}  // namespace

MailboxCore::MailboxCore(std::shared_ptr<SessionCore> session, std::shared_ptr<OwnSegment> segment,
                         std::size_t index, const MailboxOptions& options)
    : session_(std::move(session)),
      segment_(std::move(segment)),
      address_(segment_->mailboxes[index].address),
      body_max_(options.body_max),
      priority_(options.priority),
      linger_(options.linger),
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
  const os::Waiting waiting;
  for (;;) {
    if (auto taken = receiver_.take()) return *taken;
    if (closed_.load(std::memory_order_acquire)) return Errc::kClosed;
    if (deadline != kNever && os::now() >= deadline) return Errc::kTimeout;
    if (auto taken = linger(deadline)) return *taken;
    sleep(deadline);
  }
}

std::optional<shm::Taken> MailboxCore::linger(Time deadline) {
  if (linger_ <= Duration::zero()) return std::nullopt;
  const Time end = std::min(deadline, os::deadline_after(linger_));
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
      pollfd wait{event_fd_, POLLIN, 0};
      const timespec rest = os::to_timespec(Time(deadline - os::now()));
      ::ppoll(&wait, 1, deadline == kNever ? nullptr : &rest, nullptr);
      os::drain_wakes(event_fd_);
    }
  }
  receiver_.disarm();
}

// The caller goes back to its event loop: the next message must make the descriptor readable.
Result<shm::Taken> MailboxCore::arm_event_fd() {
  os::drain_wakes(event_fd_);
  receiver_.arm();
  if (receiver_.nothing_came()) return Errc::kEmpty;
  receiver_.disarm();
  if (auto taken = receiver_.take()) return *taken;
  os::wake(waker_);  // a hint without a message; look again at once
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

// An uplink has no room only for as long as the router needs for a turn.
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
  const shm::MailboxHeader& header = receiver_.view().header();
  const auto read = [](const shm::Word64& word) { return word.load(std::memory_order_relaxed); };
  return {.received = read(header.received),
          .waiting = shm::waiting(receiver_.view()),
          .replaced = read(header.replaced),
          .refused = read(header.refused),
          .too_big = read(header.too_big),
          .reclaimed = read(header.reclaimed)};
}

}  // namespace tims
