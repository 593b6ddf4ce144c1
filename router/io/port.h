// A port: where clients of one kind attach. Ports feed the router (Router::connect, on_message,
// ...) and carry out what it decides.
#pragma once

#include <cstdint>

#include "router/core/message.h"
#include "router/core/sink.h"
#include "router/core/statistics.h"

namespace tims::io {

class Port {
 public:
  virtual ~Port() = default;

  // As in core::Sink, for the clients of this port. None of them may call the router.
  virtual core::Outcome deliver(const core::Receiver& to, const core::Message& message) = 0;
  virtual void reply(const core::Receiver& to, const Header& header) = 0;
  virtual void close(const core::Receiver& client, core::CloseReason reason) = 0;

  // Its clients must come by the router with messages to this mailbox.
  virtual void moved(Address) {}

  // Ends what deliver() and reply() began since the last flush: bytes go into sockets or queues,
  // sleeping receivers are woken. After this, delivered bytes are no longer needed. May call the
  // router (losses, disconnected clients). Called after every batch; cheap when nothing is to do.
  virtual void flush(Time now) = 0;

  // What waits for a client that reads slowly.
  [[nodiscard]] virtual std::uint64_t queued_bytes(std::uint32_t token) const = 0;

  // Before the router ends: no new clients; and is there still something to be written?
  virtual void stop_accepting() = 0;
  [[nodiscard]] virtual bool drained() const = 0;

 protected:
  Port() = default;
  Port(const Port&) = default;
  Port& operator=(const Port&) = default;
};

}  // namespace tims::io
