// A mailbox: the one place where a component sends and receives messages.
//
// Threads: every call may be made from any thread. Several threads may receive from one mailbox;
// each message goes to exactly one of them. Order: higher priority first, then arrival.
//
// Cost: a message between two mailboxes of one host is one copy and at most one wake-up; no system
// call while the receiver is awake.
//
// Waiting: the first message to an address, and the first one after its owner has closed or died,
// asks the router where it is, and waits for the answer: as a rule a fraction of a millisecond, for
// a router that stands still 5 s, then kNoRouter. Who may not wait sends something to each address
// before it counts: from then on no send waits for the router, also not while it is away, slow, or
// was restarted.
//
// A router that dies: messages to this host do not need it. Those to other hosts that it had not
// taken yet, up to 1024, stay in memory of this program, and the next router gets them within 30 s;
// after that they are lost, and SessionEvent::kMessagesLost says how many. What it had taken and
// not sent on dies with it.
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
  std::uint8_t priority = 0;      // of what is sent from here, unless the envelope says otherwise
  bool event_fd = false;          // for an event loop of your own: see Mailbox::event_fd
  // How long a receive looks for the next message, and yields the processor between two looks,
  // before it sleeps: for streams, where waking costs more than the message. Zero suits real time.
  Duration spin = {};
};

// What the sender decides of a header.
struct Envelope {
  Address dest = {};
  std::int8_t type = 0;
  std::optional<std::uint8_t> priority = {};  // default: the mailbox's
  std::uint8_t seq_nr = 0;
  bool stream = false;  // a sample: a newer one may replace it where a link is short of bandwidth
  bool trace = false;   // every router on the way tells the sender (type::kHopRecord)
  // NOT_AVAILABLE when nobody owns `dest`, as for commands.
  bool tell_if_gone = false;
  bool tell_why = false;  // who refuses this command says why, behind ERROR
  // Order of the body's numbers: flag::kBodyLittleEndian or 0.
  std::uint8_t body_order = flag::kNativeOrder & flag::kBodyLittleEndian;
};

class MailboxCore;
namespace shm {
struct Taken;
}
namespace client {
struct Target;
}

// A received message, still in its slot. The slot is free again when the guard goes, which must be
// before its mailbox goes. The bytes are the sender's: to be trusted as far as the sender is.
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
  void release();  // ends the peek before the guard goes

 private:
  friend class Mailbox;
  PeekGuard() = default;

  MailboxCore* core_ = nullptr;
  std::uint64_t slot_ = 0;
  Header header_;
  std::span<const std::byte> body_;
};

// A message under construction in the receiver's own slot: nothing is copied. Without send() the
// slot goes back unused. Must go before the mailbox it was asked from.
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
  std::uint64_t received = 0;   // handed to the owner
  std::uint64_t waiting = 0;    // in the mailbox now
  std::uint64_t replaced = 0;   // thrown away for a newer message of the same or higher priority
  std::uint64_t refused = 0;    // not taken: full of more important messages
  std::uint64_t too_big = 0;    // not taken: larger than a slot
  std::uint64_t reclaimed = 0;  // half-written by a sender that died
};

class TIMS_API Mailbox {
 public:
  Mailbox(Mailbox&&) noexcept;
  Mailbox& operator=(Mailbox&&) noexcept;
  ~Mailbox();  // closes: senders learn it with their next message

  [[nodiscard]] Address address() const;
  [[nodiscard]] std::uint32_t body_max() const;  // largest body it takes, bytes
  // Of the addresses of its router's fleet.
  [[nodiscard]] AddressWidths address_widths() const;

  // Sending to a known mailbox of this host never waits. What the router has to deliver may wait
  // until it has taken earlier messages, at most 0.2 s when it stands still, then kFull; without a
  // router: kNoRouter, at once. What was sent is delivered also when the mailbox closes, or the
  // program dies, right afterwards.
  // kFull: the receiver holds only more important messages. A command
  // (type > 0) to an address nobody owns is answered by the router with type::kNotAvailable.
  Result<void> send(const Envelope& envelope, std::span<const std::byte> body = {});
  // The body in several pieces.
  Result<void> send(const Envelope& envelope, std::span<const std::span<const std::byte>> pieces);
  // Back to whoever sent `request`, with its priority and sequence number.
  Result<void> reply(const Header& request, std::int8_t type, std::span<const std::byte> body = {});
  // A slot of the receiver for a body of `body_size` bytes; kTooBig, kFull as for send.
  Result<Loan> loan(const Envelope& envelope, std::uint32_t body_size);

  // Copying. The body goes to the front of `buffer`; a message larger than the buffer stays
  // first in the mailbox (kBufferTooSmall).
  Result<MessageView> receive(std::span<std::byte> buffer);
  Result<MessageView> receive_for(std::span<std::byte> buffer, Duration timeout);  // kTimeout
  Result<MessageView> try_receive(std::span<std::byte> buffer);                    // kEmpty

  // In place.
  Result<PeekGuard> peek();
  Result<PeekGuard> peek_for(Duration timeout);  // kTimeout
  Result<PeekGuard> try_peek();                  // kEmpty

  // As Session::flush(), of its session: for who closes, but not before all has gone.
  Result<void> flush(Duration timeout = kForever);

  // Throws away every waiting message; peeked and half-written ones stay. Returns how many.
  std::size_t clean();

  [[nodiscard]] MailboxCounters counters() const;

  // With MailboxOptions::event_fd: a descriptor to poll, and for nothing else, which is readable
  // when a message has come. Call try_receive or try_peek until kEmpty after each wake-up: that
  // arms it again. -1 without the option.
  [[nodiscard]] int event_fd() const;

 private:
  friend class Session;
  explicit Mailbox(std::shared_ptr<MailboxCore> core);
  Result<PeekGuard> guard(Result<shm::Taken> taken);
  std::shared_ptr<MailboxCore> core_;
};

// --- Who watches a thread learns when it waits for a message: a wait that is meant. A detector of
// threads that are kept waiting where they must not be is told so.

class WaitObserver {
 public:
  virtual ~WaitObserver() = default;
  virtual void begins() = 0;
  virtual void ends() = 0;
};

// Of the calling thread; null: nobody.
TIMS_API void set_wait_observer(WaitObserver* observer);
TIMS_API WaitObserver* wait_observer();

// A wait of this thread, from here to the end of the scope. Mailboxes wait like this.
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
