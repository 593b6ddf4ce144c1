#include "router/io/http/http_server.h"

#include <algorithm>
#include <array>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>

#include "os/clock.h"
#include "router/io/http/http_pages.h"
#include "router/io/loop.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr std::size_t kDiscardedBytes = 4096;

asio::ip::tcp protocol_of(const os::File& socket) {
  SystemAddress address;
  ::getsockname(socket.get(), address.get(), &address.size);
  return address.family() == AF_INET ? asio::ip::tcp::v4() : asio::ip::tcp::v6();
}

}  // namespace

// --- one connection

class HttpServer::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(HttpServer& server, StreamSocket socket, Visitor visitor)
      : server_(server), socket_(std::move(socket)), visitor_(std::move(visitor)) {}

  void start(Time now) {
    deadline_ = now + server_.timeouts_.request;
    read();
  }

  // The time at which the connection is closed.
  [[nodiscard]] Time deadline() const { return deadline_; }
  [[nodiscard]] bool is_writing() const { return is_writing_; }

  [[nodiscard]] StreamSocket take_socket() { return std::move(socket_); }
  [[nodiscard]] const HttpRequest& request() const { return reader_.request(); }
  [[nodiscard]] const Visitor& visitor() const { return visitor_; }

 private:
  // A turn of its own after an operation: `step` is called with its start, and with the bytes that
  // were read or written. A broken connection is forgotten. The owner may have destroyed the
  // connection in between.
  template <typename Step>
  auto turn(Step step) {
    return [weak = weak_from_this(), step](const error_code& error, std::size_t bytes) {
      const auto self = weak.lock();
      if (!self) return;
      const Time now = os::now();
      error ? self->server_.forget(*self) : step(*self, now, bytes);
      self->server_.end_turn(now, *self);
    };
  }

  // --- Reading
  void read() {
    const auto room = reader_.room();
    socket_.async_read_some(
        asio::buffer(room.data(), room.size()),
        turn([](Connection& self, Time now, std::size_t bytes) { self.take(now, bytes); }));
  }

  void take(Time now, std::size_t bytes) {
    // Starts with the first byte, so that a client that sends byte by byte does not gain time.
    if (!reader_.is_inside()) deadline_ = now + server_.timeouts_.request;
    reader_.advance(bytes);
    serve(now);
  }

  void serve(Time now) {
    switch (reader_.next()) {
      case HttpReader::Status::kNeedMore:
        return read();
      case HttpReader::Status::kRequest:
        return serve_request(now);
      case HttpReader::Status::kRefused:
        return answer(now, reader_.refusal(), {.keep_alive = false});
    }
  }

  void serve_request(Time now) {
    const HttpRequest& request = reader_.request();
    const HttpFraming framing{.with_body = request.method != "HEAD",
                              .keep_alive = request.keep_alive && !server_.stopping_};
    if (!is_for_websocket(request))
      return answer(now, answer_http(request, visitor_, server_.pages_), framing);
    if (const auto refusal = websocket_refusal(request, visitor_, server_.pages_))
      return answer(now, *refusal, framing);
    if (reader_.pending() > 0)
      return answer(now, http_error(400, "wait for the answer before sending WebSocket data"),
                    {.keep_alive = false});
    server_.upgrade(*this);
  }

  // --- Writing
  void answer(Time now, const HttpResponse& response, HttpFraming framing) {
    output_ = to_bytes(response, framing);
    const std::string_view stored = framing.with_body ? response.stored : std::string_view();
    is_last_ = !framing.keep_alive;
    is_writing_ = true;
    deadline_ = now + server_.timeouts_.to_accept(output_.size() + stored.size());
    const std::array<asio::const_buffer, 2> buffers{asio::buffer(output_), asio::buffer(stored)};
    asio::async_write(socket_, buffers,
                      turn([](Connection& self, Time then, std::size_t) { self.go_on(then); }));
  }

  // After an answer. One request per turn, so that others are served too.
  void go_on(Time now) {
    is_writing_ = false;
    if (is_last_) return end(now);
    output_ = std::string();
    deadline_ = now + (reader_.is_inside() ? server_.timeouts_.request : server_.timeouts_.idle);
    reader_.pending() > 0 ? serve(now) : read();
  }

  // --- The end: closing with unread data would reset the connection and discard the answer.
  void end(Time now) {
    error_code ignored;
    socket_.shutdown(StreamSocket::shutdown_send, ignored);
    deadline_ = now + server_.timeouts_.final_close;
    output_.resize(kDiscardedBytes);
    read_until_closed();
  }

  void read_until_closed() {
    socket_.async_read_some(asio::buffer(output_), turn([](Connection& self, Time, std::size_t) {
                              self.read_until_closed();
                            }));
  }

  HttpServer& server_;
  StreamSocket socket_;
  const Visitor visitor_;
  HttpReader reader_;
  std::string output_;  // at the end: room for data that is discarded
  bool is_writing_ = false;
  bool is_last_ = false;  // the connection is closed after output_ is written
  Time deadline_ = kNever;
};

// --- the server

HttpServer::HttpServer(Loop& loop, Log& log, HttpPages pages, Actions actions,
                       const HttpTimeouts& timeouts)
    : loop_(loop),
      pages_(std::move(pages)),
      actions_(std::move(actions)),
      timeouts_(timeouts),
      acceptor_(loop, log, [this](os::File socket, Visitor visitor) {
        welcome(std::move(socket), std::move(visitor));
      }) {}

HttpServer::~HttpServer() = default;

void HttpServer::welcome(os::File socket, Visitor visitor) {
  const Time now = os::now();
  StreamSocket stream(loop_.context().get_executor());
  error_code error;
  if (stream.assign(protocol_of(socket), socket.get(), error)) return;
  (void)socket.release();  // the stream owns it now
  if (connections_.size() >= kConnectionsMax) drop_most_urgent();
  const auto connection =
      std::make_shared<Connection>(*this, std::move(stream), std::move(visitor));
  connections_.push_back(connection);
  connection->start(now);
  end_turn(now, *connection);
}

void HttpServer::drop_most_urgent() {
  connections_.erase(std::ranges::min_element(
      connections_, {}, [](const auto& connection) { return connection->deadline(); }));
}

void HttpServer::upgrade(Connection& connection) {
  actions_.upgrade(connection.take_socket(), connection.request(), connection.visitor());
  forget(connection);
}

void HttpServer::forget(Connection& connection) {
  std::erase_if(connections_, [&](const auto& c) { return c.get() == &connection; });
  if (connections_.empty()) next_timeout_ = kNever;
}

void HttpServer::end_turn(Time began, const Connection& connection) {
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
