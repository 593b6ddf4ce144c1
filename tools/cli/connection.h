// A mailbox at a router, over the local socket or TCP, and waiting for a message, a deadline or
// Ctrl-C, whichever comes first.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "client/tcp_client.h"
#include "os/file.h"
#include "tims/mailbox.h"
#include "tims/result.h"
#include "tims/time.h"
#include "wire/endpoint.h"

namespace timsctl {

// Makes Ctrl-C waitable. While this object exists, the signals are blocked and are received through
// a file descriptor, without a signal handler.

class Signals {
 public:
  Signals();  // before any thread is started: threads inherit the signal mask

  enum class WaitResult { kReadable, kTimeout };
  // Waits until `fd` is readable (-1: none) or the deadline. Throws Interrupted on a signal.
  WaitResult wait(int fd, tims::Time deadline) const;
  void sleep_until(tims::Time deadline) const { (void)wait(-1, deadline); }
  // Discards received signals, so that cleanup code can wait again.
  void forget() const;

 private:
  tims::os::File file_;
};

// The router that -H names.

using UnixHost = tims::wire::UnixEndpoint;
using TcpHost = tims::wire::TcpEndpoint;
using Host = tims::wire::Endpoint;

// Throws Failure if the text is invalid.
Host parse_host(std::string_view text);
// What -H names, else $TIMS_HOST, else the default router of this host.
Host host_of(std::string_view option);

using Message = tims::client::Message;

class Connection {
 public:
  virtual ~Connection() = default;

  [[nodiscard]] virtual tims::Address address() const = 0;       // of its mailbox
  [[nodiscard]] virtual tims::AddressWidths widths() const = 0;  // of the fleet's addresses
  [[nodiscard]] virtual std::string where()
      const = 0;  // name of the router for messages to the user
  virtual tims::Result<void> send(const tims::Envelope& envelope,
                                  std::span<const std::byte> body) = 0;
  // To the router itself; `envelope.dest` is filled in.
  virtual tims::Result<void> send_to_router(tims::Envelope envelope,
                                            std::span<const std::byte> body) = 0;
  // The next received message; kEmpty: none is waiting, kClosed: the connection is lost for good.
  virtual tims::Result<Message> take() = 0;
  // The number of messages lost because they arrived faster than they were taken.
  [[nodiscard]] virtual std::uint64_t missed() const = 0;
  // The number of reconnections. Requests sent before a reconnection are never answered.
  [[nodiscard]] virtual std::uint64_t losses() const { return 0; }
  // A new number for each request; it identifies the answer.
  std::uint8_t next_seq_nr() { return ++seq_nr_; }
  // Readable if take() may succeed or losses() has changed since take() returned kEmpty.
  [[nodiscard]] virtual int descriptor() const = 0;

 private:
  std::uint8_t seq_nr_ = 0;
};

struct MailboxRequest {
  std::string address;  // as the user wrote it; empty: a free address of class Tool
  std::uint32_t slots = 64;
  std::uint32_t body_max = 256U << 10;
};

using Log = std::function<void(const std::string&)>;

// Throw Failure: no router, no permission, another version.
std::unique_ptr<Connection> connect_local(const UnixHost& host, const MailboxRequest& request,
                                          tims::Duration timeout, Log log);

std::unique_ptr<Connection> connect(
    const Host& host, const MailboxRequest& request, tims::Duration timeout,
    Log log = [](const std::string&) {});

// The requested address, else a random one in this system; most are free.
tims::Address mailbox_address(const MailboxRequest& request, std::uint32_t system,
                              const tims::AddressWidths& widths);
// Whether to try another random address after `taken` addresses were in use.
bool may_draw_again(const MailboxRequest& request, int taken);

// Returns the next message, or nothing at the deadline. Throws Interrupted on Ctrl-C, Failure if
// the connection is lost. `losses`: the value of losses() when the request was sent; if it has
// changed, Failure is thrown, too.
std::optional<Message> receive(Connection& connection, const Signals& signals, tims::Time deadline,
                               std::optional<std::uint64_t> losses = {});

// Sends a request to a component and returns its answer; ERROR is one, too. Throws Failure: the
// address is not registered, or there is no answer in time.
Message ask(Connection& connection, const Signals& signals, tims::Address component,
            std::int8_t type, std::span<const std::byte> body, tims::Duration timeout);

}  // namespace timsctl
