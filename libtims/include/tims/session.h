// A program's connection to a router: that of its host, or one that is reached over TCP. It waits
// for a router that is not there yet, and registers its mailboxes again when the router was
// restarted; meanwhile mailboxes of this host that know each other go on talking.
//
// Over TCP the session is an original client to the router, which may be an original one too: what
// it sends, also from one of its mailboxes to another, goes through the router; the protocol tells
// neither the router's address nor the fleet's widths. Sending ends with kTooBig beyond
// tcp_message_max.
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
    kWaiting,       // no router answers; trying again
    kConnected,     // to a router, for the first time or again
    kLost,          // the router went away; trying again
    kMailboxLost,   // after a reconnect somebody else owns the address; tried again with the next
    kMessagesLost,  // after a reconnect: what waited for the former router is too old (mailbox.h)
  };
  Kind kind;
  std::string text;  // one line for people
};

struct SessionOptions {
  std::string name = {};  // of this program, as `timsctl` shows it; default: the process name
  // "unix:PATH", "/PATH", "HOST:PORT", "HOST" (port 2000), "[IPv6]:PORT". Default:
  // default_router().
  std::string router = {};
  Duration timeout = kForever;  // for connect(): how long to wait for a router
  // The largest message that a router reached over TCP takes, header included; it does not say so
  // itself, and closes the connection of whoever sends a larger one. Default: the original's.
  std::uint32_t tcp_message_max = 256U << 10;
  // Real-time priority (SCHED_FIFO) of the thread that carries messages to and from a router
  // reached over TCP: no less than that of whoever sends them. 0, or without the right to it: none.
  int tcp_priority = 0;
  // Called from the session's own thread. Default: all but kConnected go to stderr.
  std::function<void(const SessionEvent&)> on_event = {};
};

class SessionCore;

class TIMS_API Session {
 public:
  // Waits until the router answers (kTimeout, kVersion, kRefused; kInvalidArgument: `router`).
  static Result<Session> connect(SessionOptions options = {});

  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();  // mailboxes that are still open keep the session

  // kAddressInUse names the owner. Without a router at the moment, or with one that stands still:
  // waits for it.
  Result<Mailbox> open(const MailboxOptions& options);
  // All or none, in one exchange with the router.
  Result<std::vector<Mailbox>> open(std::span<const MailboxOptions> options);

  // Waits until the router has taken all that was sent from mailboxes of this session before: it
  // goes on from there also when this program ends. Messages to mailboxes of this host are in those
  // as soon as they are sent. Without a router: waits for the next one. kTimeout: what is left
  // still goes out as long as the session lives.
  Result<void> flush(Duration timeout = kForever);

  [[nodiscard]] bool connected() const;
  [[nodiscard]] Address router() const;  // the router's own address; over TCP 0
  // Of the fleet's addresses: what Address::parse(), of() and to_string() must be told. An
  // original router, over TCP, has the usual ones.
  [[nodiscard]] AddressWidths address_widths() const;

 private:
  explicit Session(std::shared_ptr<SessionCore> core);
  std::shared_ptr<SessionCore> core_;
};

// $TIMS_ROUTER; else the user's router, when there is one: $XDG_RUNTIME_DIR/tims/router.sock, or
// /tmp/tims-UID/router.sock in a folder of the user's own; else /run/tims/router.sock.
TIMS_API std::string default_router();

}  // namespace tims
