// Implementation of a mailbox behind its handle.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

#include "client/session.h"
#include "shm/receiver.h"
#include "tims/mailbox.h"
#include "wire/header.h"

namespace tims {

class MailboxCore {
 public:
  MailboxCore(std::shared_ptr<SessionCore> session, std::shared_ptr<OwnSegment> segment,
              std::size_t index, const MailboxOptions& options);

  void close();
  Result<shm::Taken> take_before(Time deadline);
  Result<shm::Taken> try_take();
  void put_back(const shm::Taken& taken);
  void release(shm::Hint hint) { receiver_.release(hint); }
  std::size_t clean();
  Result<void> flush(Time deadline) { return session_->flush(deadline); }

  // A slot of the receiver. `header` is completed by the caller.
  struct Draft {
    client::Target* target = nullptr;
    shm::Claim claim;
    Header header;
  };
  Result<void> claim(const Envelope& envelope, std::size_t body_size, Draft& draft);
  // The same without waiting. kTimeout: it would have to.
  Result<void> try_claim(const Envelope& envelope, std::size_t body_size, Draft& draft);
  Result<void> commit(const Draft& draft);

  [[nodiscard]] Address address() const { return address_; }
  [[nodiscard]] std::uint32_t body_max() const { return body_max_; }
  [[nodiscard]] AddressWidths address_widths() const { return session_->welcome().widths; }
  [[nodiscard]] int event_fd() const { return event_fd_; }
  [[nodiscard]] MailboxCounters counters() const;

 private:
  Result<void> begin(const Envelope& envelope, std::size_t body_size, Draft& draft) const;
  Result<void> claim_slot(Draft& draft);
  shm::SendOutcome wait_for_room(Draft& draft);
  [[nodiscard]] Error not_sent(shm::SendOutcome outcome, Address dest) const;
  Result<shm::Taken> arm_event_fd();
  std::optional<shm::Taken> spin(Time deadline);
  void sleep(Time deadline);
  void wake_own_readers();

  std::shared_ptr<SessionCore> session_;
  std::shared_ptr<OwnSegment> segment_;
  const Address address_;
  const std::uint32_t body_max_;
  const std::uint8_t priority_;
  const Duration spin_;
  const int event_fd_;  // -1: woken by a futex
  const int waker_;
  std::atomic<bool> closed_ = false;

  std::timed_mutex seat_;  // held by the thread that takes a message or sleeps
  shm::Receiver receiver_;
};

// --- hot path ---

inline Result<void> MailboxCore::begin(const Envelope& envelope, std::size_t body_size,
                                       Draft& draft) const {
  if (body_size > shm::kMessageMax - kHeaderSize) return Errc::kTooBig;
  const std::uint8_t order = envelope.body_order & flag::kBodyLittleEndian;
  const std::uint8_t stream = envelope.stream ? flag::kStream : 0;
  const std::uint8_t trace = envelope.trace ? flag::kTrace : 0;
  const std::uint8_t report_gone = envelope.report_if_gone ? flag::kReportIfGone : 0;
  const std::uint8_t reason = envelope.report_reason ? flag::kReportReason : 0;
  draft.header = {.flags = static_cast<std::uint8_t>(order | stream | trace | report_gone | reason),
                  .type = envelope.type,
                  .priority = envelope.priority.value_or(priority_),
                  .seq_nr = envelope.seq_nr,
                  .dest = envelope.dest,
                  .src = address_,
                  .length = static_cast<std::uint32_t>(kHeaderSize + body_size)};
  return {};
}

inline Result<void> MailboxCore::claim(const Envelope& envelope, std::size_t body_size,
                                       Draft& draft) {
  if (auto begun = begin(envelope, body_size, draft); !begun) return begun;
  return claim_slot(draft);
}

inline Result<void> MailboxCore::try_claim(const Envelope& envelope, std::size_t body_size,
                                           Draft& draft) {
  if (auto begun = begin(envelope, body_size, draft); !begun) return begun;
  const Header& header = draft.header;
  draft.target = session_->known_target(header.dest);
  if (draft.target == nullptr) return Errc::kTimeout;
  const auto outcome = draft.target->sender.claim(header.length, header.priority, draft.claim);
  if (shm::taken(outcome)) return {};
  const bool may_come = outcome == shm::SendOutcome::kFull && draft.target->uplink;
  if (may_come || outcome == shm::SendOutcome::kClosed) return Errc::kTimeout;
  return not_sent(outcome, header.dest);
}

inline Result<void> MailboxCore::claim_slot(Draft& draft) {
  const Header& header = draft.header;
  // The mailbox was closed since the last message: ask the router for its successor.
  for (int attempt = 0; attempt < 3; ++attempt) {
    auto target = session_->target_for(header.dest);
    if (!target) return target.error();
    draft.target = *target;
    auto outcome = draft.target->sender.claim(header.length, header.priority, draft.claim);
    if (outcome == shm::SendOutcome::kFull && draft.target->uplink) outcome = wait_for_room(draft);
    if (shm::taken(outcome)) return {};
    if (outcome != shm::SendOutcome::kClosed) return not_sent(outcome, header.dest);
  }
  return not_sent(shm::SendOutcome::kClosed, header.dest);
}

inline Result<void> MailboxCore::commit(const Draft& draft) {
  wire::encode_header(draft.header, wire::HeaderBytes(draft.claim.header, kHeaderSize));
  const auto outcome = draft.target->sender.commit(draft.claim);
  if (outcome != shm::SendOutcome::kOk) return not_sent(outcome, draft.header.dest);
  session_->wake(*draft.target);
  return {};
}

inline Result<shm::Taken> MailboxCore::try_take() {
  const std::unique_lock seat(seat_, std::try_to_lock);
  if (!seat.owns_lock()) return Errc::kEmpty;  // another thread is receiving
  if (auto taken = receiver_.take()) return *taken;
  if (closed_.load(std::memory_order_acquire)) return Errc::kClosed;
  if (event_fd_ < 0) return Errc::kEmpty;
  return arm_event_fd();
}

}  // namespace tims
