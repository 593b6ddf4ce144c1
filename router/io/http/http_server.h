// The HTTP side of the port: connections that ask for pages, within bounds of number and time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "router/io/acceptor.h"
#include "router/io/http/http_connection.h"
#include "router/io/http/http_pages.h"

namespace tims::io {

class HttpServer final : private HttpConnection::Owner {
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

  Result<config::Endpoint> listen(const config::Endpoint& where) { return acceptor_.listen(where); }
  // No new connections; those there are end with their next answer.
  void stop_accepting();
  [[nodiscard]] bool drained() const;

  // kNever while nobody is connected: an idle router has no timer.
  [[nodiscard]] Time next_timeout() const { return next_timeout_; }
  void on_timeout(Time now);

  [[nodiscard]] std::size_t size() const { return connections_.size(); }

 private:
  HttpResponse answer(const HttpRequest& request) override { return answer_http(request, pages_); }
  std::optional<HttpResponse> websocket_refusal(const HttpRequest& request) override {
    return io::websocket_refusal(request, pages_.origins());
  }
  [[nodiscard]] bool keeps_connections() const override { return !stopping_; }
  void upgrade(HttpConnection& connection) override;
  void done(HttpConnection& connection) override;
  void end_turn(Time began, const HttpConnection& connection) override;

  void welcome(os::File socket, std::string peer);
  void drop_most_urgent();

  Loop& loop_;
  const HttpPages pages_;
  const Actions actions_;
  const HttpTimeouts timeouts_;
  bool stopping_ = false;
  std::vector<std::shared_ptr<HttpConnection>> connections_;
  Time next_timeout_ = kNever;  // or earlier
  Acceptor acceptor_;
};

}  // namespace tims::io
