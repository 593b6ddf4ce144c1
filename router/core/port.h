// What the router asks of its surroundings: its ports, which carry out what it decides, and the
// program around it.
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

// A port: where clients of one kind attach. It feeds the router (Router::connect, on_message, ...)
// and carries out what that decides. But for flush(), none of these may call the router.
class Port {
 public:
  virtual ~Port() = default;

  // The bytes stay valid until the ports are flushed at the end of the turn. What is answered is
  // counted: kDelivered, kMailboxFull, kMailboxReplaced, kTooBig, kQueueFull, kClientGone or
  // kOwnerGone.
  virtual Outcome deliver(Time now, const Receiver& to, const Message& message) = 0;

  // A message without a body that the router itself made (lifesign, answer to a command,
  // NOT_AVAILABLE). `to.handle` is 0 when it goes to the connection and not to a mailbox.
  virtual void reply(Time now, const Receiver& to, const Header& header) = 0;

  // The router has already forgotten this client and its mailboxes: end its connection.
  virtual void close(const Receiver& client, CloseReason reason) = 0;

  // Its clients, if they send to this mailbox by themselves, must come by the router from now on.
  virtual void moved(Address) {}

  // Ends what deliver() and reply() began since the last flush: bytes go into sockets or queues,
  // sleeping receivers are woken. After this, delivered bytes are no longer needed. May call the
  // router (losses, disconnected clients). Called after every batch; cheap when nothing is to do.
  virtual void flush(Time) {}

  // What waits for a client that reads slowly.
  [[nodiscard]] virtual std::uint64_t queued_bytes(std::uint32_t /*token*/) const { return 0; }

  // Before the router ends: no new clients; and is there nothing left to be written?
  virtual void stop_accepting() {}
  [[nodiscard]] virtual bool drained() const { return true; }

 protected:
  Port() = default;
  Port(const Port&) = default;
  Port& operator=(const Port&) = default;
};

// The program around the router. Nothing here may call back into the router.
class Surroundings {
 public:
  virtual ~Surroundings() = default;

  // A question to the router. Answered with Router::answer(), now or later.
  virtual void admin(Time now, ClientId from, const Message& request) = 0;

  // A client of TCP or of a WebSocket asks another router. False: it may not; admin() gets the
  // question and refuses it.
  virtual bool may_ask(ClientId /*from*/, const Message& /*request*/) { return true; }

  // A message with flag TRACE is about to go from one client to another.
  virtual void traced(ClientId from, ClientId to, const Message& message) = 0;

  // Something happened that is kept in the event log.
  virtual void event(const Event& event) = 0;

 protected:
  Surroundings() = default;
  Surroundings(const Surroundings&) = default;
  Surroundings& operator=(const Surroundings&) = default;
};

}  // namespace tims::core
