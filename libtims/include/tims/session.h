// A program's connection to a router: the router of its host, or one that is reached over TCP. The
// session waits until the router is available and registers its mailboxes again after the router
// was restarted. Mailboxes of this host that have exchanged messages before continue to do so
// without a router.
//
// Over TCP the session is a client of the original protocol, and the router may be an original one.
// All messages then go through the router, also those between two mailboxes of the session. The
// original protocol reports neither the router's address nor the fleet's address widths. Messages
// larger than tcp_message_max are refused with kTooBig.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tims/export.h"
#include "tims/mailbox.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims {

struct SessionEvent {
  enum class Kind {
    kWaiting,    // no router answers; retrying
    kConnected,  // to a router, for the first time or again
    kLost,       // connection lost; retrying
    // after a reconnect another program owns the address; retried at the next reconnect
    kMailboxLost,
    kMessagesLost,  // after a reconnect: messages for the former router were too old (mailbox.h)
  };
  Kind kind;
  std::string text;  // one line for people
};

struct SessionOptions {
  std::string name = {};  // name of this program in `timsctl`; default: the process name
  // "unix:PATH", "/PATH", "HOST:PORT", "HOST" (port 2000), "[IPv6]:PORT". Default:
  // default_router().
  std::string router = {};
  Duration timeout = kForever;  // for connect(): how long to wait for a router
  // The largest message that a router reached over TCP accepts, header included. The router does
  // not report this limit itself, and closes the connection of a client that sends a larger one.
  // Default: the limit of the original router.
  std::uint32_t tcp_message_max = 256U << 10;
  // Real-time priority (SCHED_FIFO) of the thread that carries messages to and from a router
  // reached over TCP; it should be at least that of the sending threads. 0, or without the required
  // privilege: normal scheduling.
  int tcp_priority = 0;
  // Called from the session's own thread. Default: all but kConnected go to stderr.
  std::function<void(const SessionEvent&)> on_event = {};
};

// Whether a call that waits shall go on; asked about every 50 ms by the thread that waits. It must
// not use the session.
using GoOn = std::function<bool()>;

class SessionCore;

class TIMS_API Session {
 public:
  // Waits until the router answers (kTimeout, kVersion, kRefused; kInvalidArgument: `router`).
  static Result<Session> connect(SessionOptions options = {});

  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();  // mailboxes that are still open keep the connection

  // kAddressInUse names the owner. Waits while there is no router or the router does not respond.
  Result<Mailbox> open(const MailboxOptions& options);
  // Opens all or none, in one exchange with the router.
  Result<std::vector<Mailbox>> open(std::span<const MailboxOptions> options);
  // Waits only until `go_on` returns false: kTimeout, nothing is opened.
  Result<std::vector<Mailbox>> open(std::span<const MailboxOptions> options, const GoOn& go_on);

  // Waits until the router has accepted all messages sent from mailboxes of this session before the
  // call; the router then forwards them even if this program exits. Messages to mailboxes of this
  // host are delivered as soon as they are sent. Without a router: waits for the next one.
  // kTimeout: the remaining messages are still sent as long as the session exists.
  Result<void> flush(Duration timeout = kForever);

  [[nodiscard]] bool connected() const;
  [[nodiscard]] Address router() const;  // the router's own address; over TCP 0
  // Address widths of the fleet, to be passed to Address::parse(), of() and to_string(). An
  // original router, over TCP, uses the default widths.
  [[nodiscard]] AddressWidths address_widths() const;

 private:
  explicit Session(std::shared_ptr<SessionCore> core);
  std::shared_ptr<SessionCore> core_;
};

// Returns $TIMS_ROUTER if set; else the user's router if there is one:
// $XDG_RUNTIME_DIR/tims/router.sock, or /tmp/tims-UID/router.sock in a directory owned by the user;
// else /run/tims/router.sock.
TIMS_API std::string default_router();

}  // namespace tims
