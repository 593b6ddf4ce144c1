#include "router/io/http/http_server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <utility>

#include <sys/socket.h>

#include "os/clock.h"
#include "router/io/http/http_pages.h"
#include "router/io/loop.h"

namespace tims::io {
namespace {

bool is_later(int error) { return error == EAGAIN || error == EINTR; }

}  // namespace

// --- one connection

class HttpServer::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(HttpServer& server, os::File socket, std::string peer)
      : server_(server), socket_(std::move(socket)), peer_(std::move(peer)) {}

  void start(Time now) {
    deadline_ = now + server_.timeouts_.request;
    watch_.emplace(server_.loop_, socket_.get(), [this](Ready) { take_turn(); });
  }

  // The time at which the connection is closed.
  [[nodiscard]] Time deadline() const { return deadline_; }
  [[nodiscard]] bool is_writing() const { return state_ == State::kWriting; }

  os::File take_socket() {
    watch_.reset();
    state_ = State::kDone;
    return std::move(socket_);
  }

  [[nodiscard]] const HttpRequest& request() const { return reader_.request(); }
  [[nodiscard]] const std::string& peer() const { return peer_; }

 private:
  enum class State {
    kReading,
    kServing,  // the received data may contain a further request
    kWriting,
    kClosing,  // everything is written; received data is discarded
    kDone,
  };

  // --- Turns
  void schedule() {
    switch (state_) {
      case State::kReading:
      case State::kClosing:
        return watch_->set(Interest::kReading);
      case State::kWriting:
        return watch_->set(Interest::kWriting);
      case State::kServing:
        // One request per turn, so that others are served too.
        watch_->set(Interest::kNothing);
        return take_turn_later();
      case State::kDone:
        return watch_.reset();
    }
  }

  // The owner may destroy the connection in between.
  void take_turn_later() {
    server_.loop_.post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->take_turn();
    });
  }

  void take_turn() {
    const auto self = shared_from_this();  // keep alive until the end of this turn
    const Time now = os::now();
    switch (state_) {
      case State::kReading:
        read(now);
        break;
      case State::kServing:
        serve(now);
        break;
      case State::kWriting:
        write(now);
        break;
      case State::kClosing:
        read_until_closed();
        break;
      case State::kDone:
        break;
    }
    schedule();
    server_.end_turn(now, *this);
  }

  // --- Reading
  void read(Time now) {
    const auto room = reader_.room();
    const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (n < 0 && is_later(errno)) return;
    if (n <= 0) return finish();
    // Starts with the first byte, so that a client that sends byte by byte does not gain time.
    if (!reader_.is_inside()) deadline_ = now + server_.timeouts_.request;
    reader_.advance(static_cast<std::size_t>(n));
    serve(now);
  }

  void serve(Time now) {
    switch (reader_.next()) {
      case HttpReader::Status::kNeedMore:
        state_ = State::kReading;
        break;
      case HttpReader::Status::kRequest:
        serve_request(now);
        break;
      case HttpReader::Status::kRefused:
        answer(now, reader_.refusal(), {.keep_alive = false});
        break;
    }
  }

  void serve_request(Time now) {
    const HttpRequest& request = reader_.request();
    const HttpFraming framing{.with_body = request.method != "HEAD",
                              .keep_alive = request.keep_alive && !server_.stopping_};
    if (!is_for_websocket(request))
      return answer(now, answer_http(request, server_.pages_), framing);
    if (const auto refusal = websocket_refusal(request, server_.pages_.origins()))
      return answer(now, *refusal, framing);
    if (reader_.pending() > 0)
      return answer(now, http_error(400, "wait for the answer before sending WebSocket data"),
                    {.keep_alive = false});
    server_.upgrade(*this);
  }

  // --- Writing
  void answer(Time now, const HttpResponse& response, HttpFraming framing) {
    output_ = to_bytes(response, framing);
    written_ = 0;
    last_answer_ = !framing.keep_alive;
    state_ = State::kWriting;
    deadline_ = now + server_.timeouts_.answer;
    write(now);
  }

  void write(Time now) {
    const ssize_t n = ::send(socket_.get(), output_.data() + written_, output_.size() - written_,
                             MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && is_later(errno)) return;
    if (n < 0) return finish();
    written_ += static_cast<std::size_t>(n);
    if (written_ == output_.size()) after_answer(now);
  }

  void after_answer(Time now) {
    output_ = std::string();
    if (last_answer_) {
      // Closing with unread data would reset the connection and discard the answer.
      ::shutdown(socket_.get(), SHUT_WR);
      state_ = State::kClosing;
      deadline_ = now + server_.timeouts_.final_close;
      return;
    }
    state_ = reader_.pending() > 0 ? State::kServing : State::kReading;
    deadline_ = now + (reader_.is_inside() ? server_.timeouts_.request : server_.timeouts_.idle);
  }

  // --- The end
  void read_until_closed() {
    std::array<char, 4096> ignored;
    const ssize_t n = ::recv(socket_.get(), ignored.data(), ignored.size(), MSG_DONTWAIT);
    if (n == 0 || (n < 0 && !is_later(errno))) finish();
  }

  void finish() {
    state_ = State::kDone;
    server_.forget(*this);
  }

  HttpServer& server_;
  os::File socket_;
  std::optional<Watch> watch_;
  const std::string peer_;
  HttpReader reader_;
  State state_ = State::kReading;
  std::string output_;
  std::size_t written_ = 0;   // bytes of output_
  bool last_answer_ = false;  // the connection is closed after output_ is written
  Time deadline_ = kNever;
};

// --- the server

HttpServer::HttpServer(Loop& loop, Log& log, HttpPages pages, Actions actions,
                       const HttpTimeouts& timeouts)
    : loop_(loop),
      pages_(std::move(pages)),
      actions_(std::move(actions)),
      timeouts_(timeouts),
      acceptor_(loop, log, [this](os::File socket, std::string peer) {
        welcome(std::move(socket), std::move(peer));
      }) {}

HttpServer::~HttpServer() = default;

void HttpServer::welcome(os::File socket, std::string peer) {
  const Time now = os::now();
  if (connections_.size() >= kConnectionsMax) drop_most_urgent();
  const auto connection = std::make_shared<Connection>(*this, std::move(socket), std::move(peer));
  connections_.push_back(connection);
  connection->start(now);
  end_turn(now, *connection);
}

void HttpServer::drop_most_urgent() {
  connections_.erase(std::ranges::min_element(
      connections_, {}, [](const auto& connection) { return connection->deadline(); }));
}

void HttpServer::upgrade(Connection& connection) {
  actions_.upgrade(connection.take_socket(), connection.request(), connection.peer());
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
