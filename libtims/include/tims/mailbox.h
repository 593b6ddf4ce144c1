// A mailbox: a component sends and receives all its messages through mailboxes.
//
// Threads: any thread may make any call. Several threads may receive from one mailbox; each message
// goes to exactly one of them. Order: higher priority first, then order of arrival.
//
// Cost: a message between two mailboxes of one host costs one copy and at most one wake-up; no
// system call is needed while the receiver is awake.
//
// Waiting: for the first message to an address, and for the first one after its owner closed it or
// crashed, the session asks the router where the address is and waits for the answer. This usually
// takes a fraction of a millisecond; if the router does not respond, the call fails with kNoRouter
// after 5 s. A real-time program should send one message to each address during start-up: later
// sends never wait for the router, even while it is absent, slow or restarting.
//
// Router failure: messages between mailboxes of this host do not need the router. Messages to other
// hosts that the router has not accepted yet, up to 1024, stay in the memory of this program; a new
// router receives them if it starts within 30 s. After that they are lost, and
// SessionEvent::kMessagesLost reports their number. Messages that the router has accepted but not
// forwarded are lost with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "tims/export.h"
#include "tims/message.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims {

struct MailboxOptions {
  Address address = {};
  std::uint32_t slots = 16;       // messages it can hold, 1 to 65535
  std::uint32_t body_max = 4096;  // largest body it takes, bytes
  // default for messages sent from here; an Envelope may override it
  std::uint8_t priority = 0;
  bool event_fd = false;  // for an event loop of the program: see Mailbox::event_fd
  // How long a receive polls for the next message, yielding the processor between two polls, before
  // it sleeps. Useful for streams, where a wake-up costs more than the message. Use zero in
  // real-time programs.
  Duration spin = {};
};

// The header fields that the sender chooses.
struct Envelope {
  Address dest = {};
  std::int8_t type = 0;
  std::optional<std::uint8_t> priority = {};  // default: the mailbox's
  std::uint8_t seq_nr = 0;
  bool stream = false;  // a sample: a newer one may replace it where a link is short of bandwidth
  bool trace = false;   // every router on the path reports to the sender (type::kHopRecord)
  // Answer NOT_AVAILABLE when no mailbox has the address `dest`, as for commands.
  bool report_if_gone = false;
  bool report_reason =
      false;  // a receiver that refuses this command adds the reason to its ERROR reply
  // Byte order of the numbers in the body: flag::kBodyLittleEndian or 0.
  std::uint8_t body_order = flag::kNativeOrder & flag::kBodyLittleEndian;
};

class MailboxCore;
namespace shm {
struct Taken;
}
namespace client {
struct Target;
}

// A received message, still in its slot. The destructor frees the slot; destroy the guard before
// its mailbox. The memory is shared with the sender: trust the bytes only as far as the sender.
class TIMS_API PeekGuard {
 public:
  PeekGuard(PeekGuard&& other) noexcept
      : core_(std::exchange(other.core_, nullptr)),
        slot_(other.slot_),
        header_(other.header_),
        body_(other.body_) {}
  PeekGuard& operator=(PeekGuard&& other) noexcept;
  ~PeekGuard() {
    if (core_ != nullptr) release();
  }

  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] std::span<const std::byte> body() const { return body_; }
  void release();  // frees the slot before the guard is destroyed

 private:
  friend class Mailbox;
  PeekGuard() = default;

  MailboxCore* core_ = nullptr;
  std::uint64_t slot_ = 0;
  Header header_;
  std::span<const std::byte> body_;
};

// A message under construction in the receiver's own slot: nothing is copied. Without send() the
// destructor returns the slot unused. Destroy it before the mailbox that created it.
class TIMS_API Loan {
 public:
  Loan(Loan&& other) noexcept;
  Loan& operator=(Loan&& other) noexcept;
  ~Loan();

  [[nodiscard]] std::span<std::byte> body() { return body_; }
  Result<void> send();

 private:
  friend class Mailbox;
  Loan() = default;

  MailboxCore* core_ = nullptr;
  client::Target* target_ = nullptr;
  std::uint64_t word_ = 0;  // of the slot
  std::uint32_t index_ = 0;
  Header header_;
  std::span<std::byte> body_;
};

struct MailboxCounters {
  std::uint64_t received = 0;  // taken by the owner
  std::uint64_t waiting = 0;   // in the mailbox now
  // dropped in favour of a newer message of the same or higher priority
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;    // not accepted: full of more important messages
  std::uint64_t too_big = 0;    // not accepted: larger than a slot
  std::uint64_t reclaimed = 0;  // half-written by a sender that crashed
};

class TIMS_API Mailbox {
 public:
  Mailbox(Mailbox&&) noexcept;
  Mailbox& operator=(Mailbox&&) noexcept;
  ~Mailbox();  // closes; a sender notices it with its next message

  [[nodiscard]] Address address() const;
  [[nodiscard]] std::uint32_t body_max() const;  // largest body it takes, bytes
  // Address widths of the fleet that the router belongs to.
  [[nodiscard]] AddressWidths address_widths() const;

  // Sending to a known mailbox of this host never waits. A message that the router has to deliver
  // may wait until the router has accepted earlier messages: at most 0.2 s if the router does not
  // respond, then kFull. Without a router: kNoRouter, immediately. A sent message is delivered even
  // if the mailbox is closed or the program exits immediately afterwards. kFull: the receiver holds
  // only more important messages. If no mailbox has the destination address, the router answers a
  // command (type > 0) with type::kNotAvailable.
  Result<void> send(const Envelope& envelope, std::span<const std::byte> body = {});
  // As above, with the body in several pieces.
  Result<void> send(const Envelope& envelope, std::span<const std::span<const std::byte>> pieces);
  // As the first, but never waits, neither for the router nor for a place: kTimeout, it would have
  // to; nothing is sent.
  Result<void> try_send(const Envelope& envelope, std::span<const std::byte> body = {});
  // Sends to the sender of `request`, with its priority and sequence number.
  Result<void> reply(const Header& request, std::int8_t type, std::span<const std::byte> body = {});
  // Reserves a slot of the receiver for a body of `body_size` bytes; kTooBig, kFull as for send.
  Result<Loan> loan(const Envelope& envelope, std::uint32_t body_size);

  // Copying: the body is written to the front of `buffer`. A message larger than the buffer stays
  // first in the mailbox (kBufferTooSmall).
  Result<MessageView> receive(std::span<std::byte> buffer);
  Result<MessageView> receive_for(std::span<std::byte> buffer, Duration timeout);  // kTimeout
  Result<MessageView> try_receive(std::span<std::byte> buffer);                    // kEmpty

  // In place, without a copy.
  Result<PeekGuard> peek();
  Result<PeekGuard> peek_for(Duration timeout);  // kTimeout
  Result<PeekGuard> try_peek();                  // kEmpty

  // As Session::flush() of its session: call it before closing when all messages must be sent.
  Result<void> flush(Duration timeout = kForever);

  // Discards every waiting message, except those that are being read or written. Returns the number
  // of discarded messages.
  std::size_t clean();

  [[nodiscard]] MailboxCounters counters() const;

  // With MailboxOptions::event_fd: a descriptor that is readable when a message has arrived. Use it
  // only for polling. After each wake-up call try_receive or try_peek until kEmpty: that arms it
  // again, unless another thread is receiving at that moment. So one thread at a time receives from
  // such a mailbox. -1 without the option.
  [[nodiscard]] int event_fd() const;

 private:
  friend class Session;
  explicit Mailbox(std::shared_ptr<MailboxCore> core);
  Result<PeekGuard> guard(Result<shm::Taken> taken);
  std::shared_ptr<MailboxCore> core_;
};

// --- Observation of waits. A watchdog that detects blocked threads is informed through this
// interface that a thread waits for a message on purpose.

class WaitObserver {
 public:
  virtual ~WaitObserver() = default;
  virtual void begins() = 0;
  virtual void ends() = 0;
};

// Sets the observer of the calling thread; null removes it.
TIMS_API void set_wait_observer(WaitObserver* observer);
TIMS_API WaitObserver* wait_observer();

// Marks a wait of this thread, from here to the end of the scope. Mailboxes mark their waits with
// it.
class Waiting {
 public:
  Waiting() : observer_(wait_observer()) {
    if (observer_ != nullptr) observer_->begins();
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  ~Waiting() {
    if (observer_ != nullptr) observer_->ends();
  }

 private:
  WaitObserver* const observer_;
};

}  // namespace tims
