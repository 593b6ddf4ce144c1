// The HTTP side of the port: connections that ask for pages, within bounds of number and time. Each
// reads a request, writes the answer, and so on, until it closes or becomes a WebSocket.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "os/file.h"
#include "router/io/acceptor.h"
#include "router/io/http/http_pages.h"
#include "tims/time.h"

namespace tims::io {

struct HttpTimeouts {
  Duration request = std::chrono::seconds(10);  // to begin one; and to end one that has begun
  Duration idle = std::chrono::seconds(60);     // to begin a further one
  Duration answer = std::chrono::seconds(10);   // to take all of an answer
  Duration goodbye = std::chrono::seconds(2);   // to close behind the last answer
};

class HttpServer {
 public:
  // Beyond this many, the connection that has the least time left makes room for a new one.
  static constexpr std::size_t kConnectionsMax = 64;

  struct Actions {
    // A WebSocket may begin.
    std::function<void(os::File socket, const HttpRequest& request, const std::string& peer)>
        upgrade;
    std::function<void(Time began)> end_turn;
  };

  HttpServer(Loop& loop, Log& log, HttpPages pages, Actions actions, const HttpTimeouts& timeouts);
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;
  ~HttpServer();

  Result<config::Endpoint> listen(const config::Endpoint& where) { return acceptor_.listen(where); }
  // No new connections; those there are end with their next answer.
  void stop_accepting();
  [[nodiscard]] bool drained() const;

  // kNever while nobody is connected: an idle router has no timer.
  [[nodiscard]] Time next_timeout() const { return next_timeout_; }
  void on_timeout(Time now);

  [[nodiscard]] std::size_t size() const { return connections_.size(); }

 private:
  class Connection;

  void welcome(os::File socket, std::string peer);
  void drop_most_urgent();
  // It goes on as a WebSocket.
  void upgrade(Connection& connection);
  // It is over.
  void forget(Connection& connection);
  // At the end of each turn that began with this connection, which may be forgotten by now.
  void end_turn(Time began, const Connection& connection);

  Loop& loop_;
  const HttpPages pages_;
  const Actions actions_;
  const HttpTimeouts timeouts_;
  bool stopping_ = false;
  std::vector<std::shared_ptr<Connection>> connections_;
  Time next_timeout_ = kNever;  // or earlier
  Acceptor acceptor_;
};

}  // namespace tims::io
