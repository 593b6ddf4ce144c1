#include "router/io/http/http_connection.h"

#include <array>
#include <cerrno>
#include <utility>

#include <sys/socket.h>

#include "os/clock.h"
#include "router/io/http/http_pages.h"

namespace tims::io {
namespace {

bool is_later(int error) { return error == EAGAIN || error == EINTR; }

}  // namespace

HttpConnection::HttpConnection(Loop& loop, os::File socket, std::string peer,
                               const HttpTimeouts& timeouts, Owner& owner)
    : loop_(loop),
      socket_(std::move(socket)),
      peer_(std::move(peer)),
      timeouts_(timeouts),
      owner_(owner) {}

void HttpConnection::start(Time now) {
  deadline_ = now + timeouts_.request;
  watch_.emplace(loop_, socket_.get(), [this](Ready) { take_turn(); });
}

os::File HttpConnection::take_socket() {
  watch_.reset();
  state_ = State::kDone;
  return std::move(socket_);
}

// --- Turns

void HttpConnection::schedule() {
  switch (state_) {
    case State::kReading:
    case State::kGoodbye:
      return watch_->set(Interest::kReading);
    case State::kWriting:
      return watch_->set(Interest::kWriting);
    case State::kServing:
      // One request a turn: others wait, too.
      watch_->set(Interest::kNothing);
      return take_turn_later();
    case State::kDone:
      return watch_.reset();
  }
}

// The owner may forget the connection at any time: then it is too late.
void HttpConnection::take_turn_later() {
  loop_.post([weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->take_turn();
  });
}

void HttpConnection::take_turn() {
  const auto self = shared_from_this();  // until the end of this turn
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
    case State::kGoodbye:
      read_goodbye();
      break;
    case State::kDone:
      break;
  }
  schedule();
  owner_.end_turn(now, *this);
}

// --- Reading

void HttpConnection::read(Time now) {
  const auto room = reader_.room();
  const ssize_t n = ::recv(socket_.get(), room.data(), room.size(), MSG_DONTWAIT);
  if (n < 0 && is_later(errno)) return;
  if (n <= 0) return finish();
  // From its first byte on: whoever sends byte by byte does not win time.
  if (!reader_.is_inside()) deadline_ = now + timeouts_.request;
  reader_.advance(static_cast<std::size_t>(n));
  serve(now);
}

void HttpConnection::serve(Time now) {
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

void HttpConnection::serve_request(Time now) {
  const HttpRequest& request = reader_.request();
  const HttpFraming framing{.with_body = request.method != "HEAD",
                            .keep_alive = request.keep_alive && owner_.keeps_connections()};
  if (!is_for_websocket(request)) return answer(now, owner_.answer(request), framing);
  if (const auto refusal = owner_.websocket_refusal(request)) return answer(now, *refusal, framing);
  if (reader_.pending() > 0)
    return answer(now, http_error(400, "a WebSocket begins with the answer: wait for it"),
                  {.keep_alive = false});
  owner_.upgrade(*this);
}

// --- Writing

void HttpConnection::answer(Time now, const HttpResponse& response, HttpFraming framing) {
  output_ = to_bytes(response, framing);
  written_ = 0;
  last_answer_ = !framing.keep_alive;
  state_ = State::kWriting;
  deadline_ = now + timeouts_.answer;
  write(now);
}

void HttpConnection::write(Time now) {
  const ssize_t n = ::send(socket_.get(), output_.data() + written_, output_.size() - written_,
                           MSG_DONTWAIT | MSG_NOSIGNAL);
  if (n < 0 && is_later(errno)) return;
  if (n < 0) return finish();
  written_ += static_cast<std::size_t>(n);
  if (written_ == output_.size()) after_answer(now);
}

void HttpConnection::after_answer(Time now) {
  output_ = std::string();
  if (last_answer_) {
    // Closing while something unread has come would reset the connection, and with it the answer.
    ::shutdown(socket_.get(), SHUT_WR);
    state_ = State::kGoodbye;
    deadline_ = now + timeouts_.goodbye;
    return;
  }
  state_ = reader_.pending() > 0 ? State::kServing : State::kReading;
  deadline_ = now + (reader_.is_inside() ? timeouts_.request : timeouts_.idle);
}

// --- The end

void HttpConnection::read_goodbye() {
  std::array<char, 4096> ignored;
  const ssize_t n = ::recv(socket_.get(), ignored.data(), ignored.size(), MSG_DONTWAIT);
  if (n == 0 || (n < 0 && !is_later(errno))) finish();
}

void HttpConnection::finish() {
  state_ = State::kDone;
  owner_.done(*this);
}

}  // namespace tims::io
