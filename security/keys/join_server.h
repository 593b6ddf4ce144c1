// Joining and renewing over TCP: the side of the base. One thread, no waiting: the caller polls.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "os/file.h"
#include "security/crypto/tls_session.h"
#include "security/keys/join_desk.h"
#include "tims/time.h"

namespace tims::security {

class JoinServer {
 public:
  static constexpr std::size_t kConnectionsMax = 32;
  static constexpr Duration kConnectionTime = std::chrono::seconds(10);

  // Listens on all addresses of this host. `port` 0: any free port. The folder must have an
  // authority and the base's own certificate. One server at a time for a folder: kAddressInUse.
  static Result<JoinServer> listen(const KeyFolder& keys, std::uint16_t port);

  [[nodiscard]] std::uint16_t port() const { return port_; }
  // Readable when work() has something to do.
  [[nodiscard]] int descriptor() const { return epoll_.get(); }
  [[nodiscard]] Time next_timeout() const;  // kNever: none
  // Serves all connections as far as possible without waiting. `wall`: seconds since 1970. Returns
  // what happened, one line each, for the log.
  std::vector<std::string> work(Time now, std::int64_t wall);

  // The port of the server that runs for this folder, in whatever process; empty: none runs.
  static std::optional<std::uint16_t> running(const KeyFolder& keys);

 private:
  struct Connection {
    os::File socket;
    std::string source;
    std::unique_ptr<TlsSession> tls;
    Bytes request;
    Bytes out;  // what the socket has not taken
    Time ends{};
    bool answered = false;
  };
  using Connections = std::map<int, Connection>;

  JoinServer(KeyFolder keys, os::File lock, os::File listener, os::File epoll, std::uint16_t port)
      : keys_(std::move(keys)),
        lock_(std::move(lock)),
        listener_(std::move(listener)),
        epoll_(std::move(epoll)),
        port_(port),
        desk_(keys_) {}

  void accept(Time now, std::vector<std::string>& events);
  // False: the connection has ended.
  bool serve(Connection& connection, std::int64_t wall, std::vector<std::string>& events);
  bool receive(Connection& connection);
  bool flush(Connection& connection);
  void answer(Connection& connection, std::int64_t wall, std::vector<std::string>& events);
  void watch(const Connection& connection, int operation) const;

  KeyFolder keys_;
  os::File lock_;  // of authority/serving, held while this server exists
  os::File listener_;
  os::File epoll_;
  std::uint16_t port_;
  JoinDesk desk_;
  Connections connections_;
};

}  // namespace tims::security
