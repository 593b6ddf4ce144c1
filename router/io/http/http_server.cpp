#include "router/io/http/http_server.h"

#include <algorithm>
#include <utility>

#include "os/clock.h"

namespace tims::io {

HttpServer::HttpServer(Loop& loop, Log& log, HttpPages pages, Actions actions,
                       const HttpTimeouts& timeouts)
    : loop_(loop),
      pages_(std::move(pages)),
      actions_(std::move(actions)),
      timeouts_(timeouts),
      acceptor_(loop, log, [this](os::File socket, std::string peer) {
        welcome(std::move(socket), std::move(peer));
      }) {}

void HttpServer::welcome(os::File socket, std::string peer) {
  const Time now = os::now();
  if (connections_.size() >= kConnectionsMax) drop_most_urgent();
  HttpConnection::Owner& owner = *this;
  const auto connection =
      std::make_shared<HttpConnection>(loop_, std::move(socket), std::move(peer), timeouts_, owner);
  connections_.push_back(connection);
  connection->start(now);
  end_turn(now, *connection);
}

void HttpServer::drop_most_urgent() {
  connections_.erase(std::ranges::min_element(
      connections_, {}, [](const auto& connection) { return connection->deadline(); }));
}

void HttpServer::upgrade(HttpConnection& connection) {
  actions_.upgrade(connection.take_socket(), connection.request(), connection.peer());
  done(connection);
}

void HttpServer::done(HttpConnection& connection) {
  std::erase_if(connections_, [&](const auto& c) { return c.get() == &connection; });
  if (connections_.empty()) next_timeout_ = kNever;
}

void HttpServer::end_turn(Time began, const HttpConnection& connection) {
  if (!connections_.empty()) next_timeout_ = std::min(next_timeout_, connection.deadline());
  actions_.end_turn(began);
}

void HttpServer::on_timeout(Time now) {
  std::erase_if(connections_, [&](const auto& c) { return c->deadline() <= now; });
  next_timeout_ = kNever;
  for (const auto& c : connections_) next_timeout_ = std::min(next_timeout_, c->deadline());
}

void HttpServer::stop_accepting() {
  stopping_ = true;
  acceptor_.stop();
}

bool HttpServer::drained() const {
  return std::ranges::none_of(connections_, [](const auto& c) { return c->is_writing(); });
}

}  // namespace tims::io
