// A listening socket, TCP or Unix. Survives a process without free descriptors: newcomers are then
// turned away at once instead of waking the loop again and again.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "os/file.h"
#include "router/config/config.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "tims/result.h"

namespace tims::io {

// Of a socket that was bound early (os/socket.h).
inline std::string waits_for_address(const char* protocol, const config::Endpoint& where) {
  return std::string(protocol) + " " + where.to_string() +
         ": this host has no such address yet; waiting for it";
}

class Acceptor {
 public:
  // A connected, non-blocking socket and where it comes from: "127.0.0.1:54321"; a Unix socket
  // says nothing.
  using OnConnection = std::function<void(os::File socket, std::string peer)>;

  Acceptor(
      Loop& loop, Log& log, OnConnection on_connection,
      std::function<void()> on_turned_away = [] {});
  Acceptor(const Acceptor&) = delete;
  Acceptor& operator=(const Acceptor&) = delete;

  // Where it listens: the port that the system chose when 0 was asked for.
  Result<config::Endpoint> listen(const config::Endpoint& where);
  // A socket that listens already, and does not block.
  void listen(os::File listening);
  void stop();

 private:
  enum class Next {
    kMore,   // there may be another one
    kWait,   // until one comes
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
  os::File file_;
  std::optional<Watch> watch_;
  Timer pause_;
  os::File spare_;  // given up for a moment to accept, and close, what there is no descriptor for
};

}  // namespace tims::io
