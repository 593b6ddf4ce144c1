// A listening socket, TCP or Unix. Survives running out of file descriptors: new connections are
// then refused immediately instead of waking the loop repeatedly.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "os/file.h"
#include "os/socket_store.h"
#include "router/config/config.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/net/addresses.h"
#include "router/io/tls_gate.h"
#include "router/io/visitor.h"
#include "tims/result.h"

namespace tims::io {

// Warning for a socket that was bound before its address existed (os/socket.h).
inline std::string waits_for_address(const char* protocol, const config::Endpoint& where) {
  return std::string(protocol) + " " + where.to_string() +
         ": this host has no such address yet; waiting for it";
}

class Acceptor {
 public:
  // A connected, non-blocking socket, and who is at its other end.
  using OnConnection = std::function<void(os::File socket, Visitor visitor)>;

  Acceptor(
      Loop& loop, Log& log, OnConnection on_connection,
      std::function<void()> on_turned_away = [] {});
  Acceptor(const Acceptor&) = delete;
  Acceptor& operator=(const Acceptor&) = delete;

  // Returns the listening address, with the port that the system chose when 0 was requested.
  // `store`: what may have the socket already, and keeps it; nullptr: nothing.
  Result<config::Endpoint> listen(const config::Endpoint& where, os::SocketStore* store = nullptr);
  // A socket that is already listening and non-blocking.
  void listen(os::File listening);
  void stop();
  // From now on, connections come by the gate, which outlives this object.
  void guard_by(TlsGate& gate, TlsGate::Entrance entrance) {
    gate_ = &gate;
    entrance_ = std::move(entrance);
  }

 private:
  Result<os::File> open(const config::Endpoint& where, SystemAddress& address);

  enum class Next {
    kMore,   // there may be more connections
    kWait,   // until one arrives
    kPause,  // nothing can be accepted at the moment
  };

  void accept();
  Next accept_some();
  Next accept_failed(int error);
  Next turn_one_away();

  Loop& loop_;
  Log& log_;
  OnConnection on_connection_;
  std::function<void()> on_turned_away_;
  TlsGate* gate_ = nullptr;
  TlsGate::Entrance entrance_{};
  os::File file_;
  std::optional<Watch> watch_;
  Timer pause_;
  // Released temporarily to accept and close a connection when there is no other descriptor.
  os::File spare_;
};

}  // namespace tims::io
