// One mailbox at one router, over the local socket or over TCP alike; and how a command waits: for
// a message, a deadline or Ctrl-C, whichever comes first.
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

// Ctrl-C as something that can be waited for. Signals are blocked while this exists and come in
// through a descriptor: no handler, no flag.

class Signals {
 public:
  Signals();  // before any thread is started: threads inherit what is blocked

  enum class WaitResult { kReadable, kTimeout };
  // Until `fd` can be read (-1: none), the deadline, or a signal: then throws Interrupted.
  WaitResult wait(int fd, tims::Time deadline) const;
  void sleep_until(tims::Time deadline) const { (void)wait(-1, deadline); }
  // The signals that have come, so that there can be waited again: for what has to be done at the
  // end.
  void forget() const;

 private:
  tims::os::File file_;
};

// Which router -H names.

using UnixHost = tims::wire::UnixEndpoint;
using TcpHost = tims::wire::TcpEndpoint;
using Host = tims::wire::Endpoint;

// Throws Failure when it names none.
Host parse_host(std::string_view text);

using Message = tims::client::Message;

class Connection {
 public:
  virtual ~Connection() = default;

  [[nodiscard]] virtual tims::Address address() const = 0;       // of its mailbox
  [[nodiscard]] virtual tims::AddressWidths widths() const = 0;  // of the fleet's addresses
  [[nodiscard]] virtual std::string where() const = 0;           // the router, for people
  virtual tims::Result<void> send(const tims::Envelope& envelope,
                                  std::span<const std::byte> body) = 0;
  // To the router itself; `envelope.dest` is filled in.
  virtual tims::Result<void> send_to_router(tims::Envelope envelope,
                                            std::span<const std::byte> body) = 0;
  // What has come; kEmpty when nothing has, kClosed when the router has gone for good.
  virtual tims::Result<Message> take() = 0;
  // Messages that came faster than they were taken, and are lost.
  [[nodiscard]] virtual std::uint64_t missed() const = 0;
  // How often the router went away and the connection was made anew: what was asked before will
  // never be answered.
  [[nodiscard]] virtual std::uint64_t losses() const { return 0; }
  // A new one for each question: answers are told apart by it.
  std::uint8_t next_seq_nr() { return ++seq_nr_; }
  // Readable when take() may have something or losses() has grown, after take() said kEmpty.
  [[nodiscard]] virtual int descriptor() const = 0;

 private:
  std::uint8_t seq_nr_ = 0;
};

struct MailboxRequest {
  std::string address;  // as people write it; default: a free one of class Tool
  std::uint32_t slots = 64;
  std::uint32_t body_max = 256U << 10;
};

using Log = std::function<void(const std::string&)>;

// Throw Failure: no router there, not allowed, another version.
std::unique_ptr<Connection> connect_local(const UnixHost& host, const MailboxRequest& request,
                                          tims::Duration timeout, Log log);
std::unique_ptr<Connection> connect_tcp(const TcpHost& host, const MailboxRequest& request,
                                        tims::Duration timeout);

// The one wished for, else one drawn at random in this system: most are free.
tims::Address mailbox_address(const MailboxRequest& request, std::uint32_t system,
                              const tims::AddressWidths& widths);
// Whether to try another one, after so many were taken.
bool may_draw_again(const MailboxRequest& request, int taken);

// The next message; nothing at the deadline. Throws Interrupted on Ctrl-C, Failure when the
// connection is lost. With `losses`, that of the connection when a question was sent, also when it
// was made anew since.
std::optional<Message> receive(Connection& connection, const Signals& signals, tims::Time deadline,
                               std::optional<std::uint64_t> losses = {});

}  // namespace timsctl
