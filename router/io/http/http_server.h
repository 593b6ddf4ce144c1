// The HTTP side of the port: connections that request pages, limited in number and time. Each
// reads a request, writes the answer, and repeats, until it closes or becomes a WebSocket.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "os/file.h"
#include "router/io/acceptor.h"
#include "router/io/http/http_pages.h"
#include "router/io/http/stream_socket.h"
#include "tims/time.h"

namespace tims::io {

struct HttpTimeouts {
  Duration request = std::chrono::seconds(10);     // to begin a request; and to complete it
  Duration idle = std::chrono::seconds(60);        // to begin a further request
  Duration answer = std::chrono::seconds(10);      // to accept an answer, and in addition
  double answer_bytes_per_s = 16'000;              // this much of it
  Duration final_close = std::chrono::seconds(2);  // to close after the last answer

  // A client on a slow network has more time for a longer answer.
  [[nodiscard]] Duration to_accept(std::size_t bytes) const {
    return answer + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(
                        static_cast<double>(bytes) / answer_bytes_per_s));
  }
};

class HttpServer {
 public:
  // Beyond this number, the connection with the least time left is closed for a new one.
  static constexpr std::size_t kConnectionsMax = 64;

  struct Actions {
    // The request is a permitted WebSocket upgrade.
    std::function<void(StreamSocket socket, const HttpRequest& request, const Visitor& visitor)>
        upgrade;
    std::function<void(Time began)> end_turn;
  };

  HttpServer(Loop& loop, Log& log, HttpPages pages, Actions actions, const HttpTimeouts& timeouts);
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;
  ~HttpServer();

  Result<config::Endpoint> listen(const config::Endpoint& where, os::SocketStore* store = nullptr) {
    return acceptor_.listen(where, store);
  }
  void guard_by(TlsGate& gate, TlsGate::Entrance entrance) {
    acceptor_.guard_by(gate, std::move(entrance));
  }
  // Accepts no new connections; existing ones are closed after their next answer.
  void stop_accepting();
  [[nodiscard]] bool drained() const;

  // kNever while there are no connections: an idle router has no timer.
  [[nodiscard]] Time next_timeout() const { return next_timeout_; }
  void on_timeout(Time now);

  [[nodiscard]] std::size_t size() const { return connections_.size(); }

 private:
  class Connection;

  void welcome(os::File socket, Visitor visitor);
  void drop_most_urgent();
  // The connection continues as a WebSocket.
  void upgrade(Connection& connection);
  // The connection is finished.
  void forget(Connection& connection);
  // Called at the end of each turn that began with this connection, which may be destroyed by
  // now.
  void end_turn(Time began, const Connection& connection);

  Loop& loop_;
  const HttpPages pages_;
  const Actions actions_;
  const HttpTimeouts timeouts_;
  bool stopping_ = false;
  std::vector<std::shared_ptr<Connection>> connections_;
  Time next_timeout_ = kNever;  // lower bound
  Acceptor acceptor_;
};

}  // namespace tims::io
