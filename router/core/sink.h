// What the router asks of its surroundings. Nothing here may call back into the router.
#pragma once

#include <cstdint>

#include "router/core/ids.h"
#include "router/core/message.h"
#include "router/core/statistics.h"

namespace tims::core {

struct Receiver {
  ClientId client{};
  PortKind port = PortKind::kTcp;
  std::uint32_t token = 0;   // the port's own number for this client (ClientInfo::token)
  std::uint32_t handle = 0;  // the port's own number for this mailbox (register_mailbox)
};

class Sink {
 public:
  virtual ~Sink() = default;

  // The bytes stay valid until the ports are flushed at the end of the turn. What is answered is
  // counted: kDelivered, kMailboxFull, kMailboxReplaced, kTooBig, kQueueFull, kClientGone or
  // kOwnerGone.
  virtual Outcome deliver(const Receiver& to, const Message& message) = 0;

  // A message without a body that the router itself made (lifesign, answer to a command,
  // NOT_AVAILABLE). `to.handle` is 0 when it goes to the connection and not to a mailbox.
  virtual void reply(const Receiver& to, const Header& header) = 0;

  // The router has already forgotten this client and its mailboxes: end its connection.
  virtual void close(const Receiver& client, CloseReason reason) = 0;

  // A question to the router. Answered with Router::answer(), now or later.
  virtual void admin(ClientId from, const Message& request) = 0;

  // A client of TCP or of a WebSocket asks another router. False: it may not; admin() gets the
  // question and refuses it.
  virtual bool may_ask(ClientId /*from*/, const Message& /*request*/) { return true; }

  // A message with flag TRACE is about to go from one client to another.
  virtual void traced(ClientId from, ClientId to, const Message& message) = 0;

  // Local programs that send to this mailbox by themselves must come by the router from now on.
  virtual void moved(Address) {}

  // Something happened that is kept in the event log.
  virtual void event(const Event& event) = 0;

 protected:
  Sink() = default;
  Sink(const Sink&) = default;
  Sink& operator=(const Sink&) = default;
};

}  // namespace tims::core
