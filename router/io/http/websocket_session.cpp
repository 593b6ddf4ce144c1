#include "router/io/http/websocket_session.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "router/io/loop.h"
#include "wire/header.h"

namespace tims::io {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using beast::error_code;
using core::CloseReason;

// Without compression, which is not useful for binary data.
using Stream = websocket::stream<StreamSocket, false>;

// A larger receive buffer is freed after its message.
constexpr std::size_t kKeptBufferBytes = 64 << 10;
// Limit of unsent bytes in the system's buffer. Urgent messages and pings wait behind them, so
// more would only increase their delay.
constexpr int kUnsentBytes = 128 << 10;

void set_options(StreamSocket& socket) {
  error_code ignored;
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes,
               sizeof kUnsentBytes);
}

http::request<http::empty_body> to_beast(const HttpRequest& request) {
  http::request<http::empty_body> message;
  message.method_string(request.method);
  message.target(request.target);
  message.version(static_cast<unsigned>(request.version));
  for (const HttpRequest::Field& field : request.fields) message.insert(field.name, field.value);
  return message;
}

CloseReason reason_for(const error_code& error) {
  if (error == websocket::error::message_too_big) return CloseReason::kTooLong;
  if (error == websocket::error::closed || error == asio::error::eof)
    return CloseReason::kPeerClosed;
  if (error == websocket::condition::protocol_violation) return CloseReason::kBadRecord;
  return CloseReason::kConnectionLost;
}

class Session final : public WebSocketSession, public std::enable_shared_from_this<Session> {
 public:
  Session(Loop& loop, StreamSocket socket, const Settings& settings, Listener& listener)
      : stream_(std::move(socket)),
        listener_(&listener),
        settings_(settings),
        life_timer_(loop, [this] { ask_whether_it_lives(); }),
        close_timer_(loop, [this] { cut(); }),
        input_(settings.message_max + kKeptBufferBytes) {
    stream_.read_message_max(settings.message_max);
    stream_.auto_fragment(false);
    stream_.binary(true);
    stream_.set_option(websocket::stream_base::decorator(
        [](websocket::response_type& answer) { answer.set(http::field::server, "tims-router"); }));
    stream_.set_option(
        websocket::stream_base::timeout{.handshake_timeout = websocket::stream_base::none(),
                                        .idle_timeout = websocket::stream_base::none(),
                                        .keep_alive_pings = false});
    stream_.control_callback(
        [this](websocket::frame_type, beast::string_view) { received_ = true; });
  }

  void accept(const HttpRequest& request);

  void set_ping_interval(Duration interval) override;
  void write(std::span<const std::span<const std::byte>> pieces, bool last) override;
  void close(WebSocketClose code, std::string reason) override;
  void drop() override;

 private:
  void read();
  void on_read();
  void ask_after(Duration time);
  void ask_whether_it_lives();
  void fail(CloseReason reason);
  void end_when_quiet();
  void cut();
  // Wraps an action to be executed when an operation succeeds.
  template <typename Action>
  auto finish(Action action);

  Stream stream_;
  Listener* listener_;  // null: no more calls
  Settings settings_;
  Timer life_timer_;
  Timer close_timer_;
  beast::flat_buffer input_;
  std::array<asio::const_buffer, kFramePiecesMax> output_;
  int pending_ = 0;  // operations in progress
  bool open_ = false;
  bool received_ = true;            // data received since the last ping
  bool asking_ = false;             // a ping is in flight
  bool writing_ = false;            // a frame is being written
  std::uint64_t acknowledged_ = 0;  // bytes acknowledged by the other side at the last ping
  bool closing_ = false;
  std::optional<CloseReason> end_;  // set when the session has ended; the first reason is kept
};

// Each operation holds the session until its completion.
template <typename Action>
auto Session::finish(Action action) {
  ++pending_;
  return [self = shared_from_this(), action](const error_code& error, std::size_t = 0) {
    --self->pending_;
    if (error)
      self->fail(reason_for(error));
    else if (!self->end_ && self->listener_ != nullptr)
      action(*self);
    self->end_when_quiet();
  };
}

void Session::accept(const HttpRequest& request) {
  life_timer_.set(os::now() + settings_.handshake_timeout);
  stream_.async_accept(to_beast(request), finish([](Session& self) {
                         self.open_ = true;
                         self.ask_after(self.settings_.ping_interval);
                         self.listener_->on_open();
                         self.read();
                       }));
}

// --- reading

void Session::read() {
  if (closing_ || listener_ == nullptr) return;
  stream_.async_read_some(input_, 0, finish([](Session& self) { self.on_read(); }));
}

void Session::on_read() {
  received_ = true;
  if (stream_.is_message_done()) {
    const auto bytes = input_.data();
    if (closing_) {
      // Discarded.
    } else if (stream_.got_text()) {
      listener_->on_text();
    } else {
      listener_->on_message({static_cast<std::byte*>(bytes.data()), bytes.size()});
    }
    input_.clear();
    if (input_.capacity() > kKeptBufferBytes) input_.shrink_to_fit();
  } else if (!closing_) {
    listener_->on_part(input_.size());
  }
  read();
}

// --- liveness
//
// Beast's own keep-alive does not notice that a slow reader, which the ping has not reached yet,
// is still reading its queued data.

void Session::set_ping_interval(Duration interval) {
  settings_.ping_interval = interval;
  if (open_) ask_after(interval);
}

void Session::ask_after(Duration time) { life_timer_.set(os::now() + time); }

void Session::ask_whether_it_lives() {
  if (closing_ || end_ || listener_ == nullptr) return;
  const auto self = shared_from_this();  // keep alive until the end was reported
  const std::uint64_t acknowledged = os::bytes_acknowledged(stream_.next_layer().native_handle());
  const bool reads = acknowledged != std::exchange(acknowledged_, acknowledged);
  if (!open_ || (!std::exchange(received_, false) && !(writing_ && reads))) {
    fail(CloseReason::kWatchdog);
    return end_when_quiet();
  }
  if (!std::exchange(asking_, true))
    stream_.async_ping({}, finish([](Session& s) { s.asking_ = false; }));
  ask_after(settings_.ping_interval);
}

// --- writing

void Session::write(std::span<const std::span<const std::byte>> pieces, bool last) {
  for (std::size_t i = 0; i < pieces.size(); ++i)
    output_[i] = asio::const_buffer(pieces[i].data(), pieces[i].size());
  writing_ = true;
  stream_.async_write_some(last, std::span<const asio::const_buffer>(output_).first(pieces.size()),
                           finish([](Session& self) {
                             self.writing_ = false;
                             self.listener_->on_written();
                           }));
}

// --- the end

void Session::close(WebSocketClose code, std::string reason) {
  if (closing_ || end_) return;
  closing_ = true;
  reason.resize(std::min(reason.size(), websocket::reason_string::static_capacity));
  // Beast's own time-out starts only when the previous frame is written, which may never happen.
  close_timer_.set(os::now() + settings_.close_timeout);
  stream_.async_close({static_cast<websocket::close_code>(code), beast::string_view(reason)},
                      finish([](Session& self) { self.fail(CloseReason::kNone); }));
}

void Session::drop() {
  listener_ = nullptr;
  cut();
}

void Session::fail(CloseReason reason) {
  if (!end_) end_ = reason;
  // During closing, the closing handshake determines the end.
  if (!closing_) cut();
}

void Session::end_when_quiet() {
  if (!end_ || pending_ > 0) return;
  cut();
  if (Listener* listener = std::exchange(listener_, nullptr)) {
    listener->on_end(*end_, input_.size());
  }
}

void Session::cut() {
  life_timer_.cancel();
  close_timer_.cancel();
  error_code ignored;
  stream_.next_layer().close(ignored);
}

}  // namespace

std::shared_ptr<WebSocketSession> WebSocketSession::start(Loop& loop, StreamSocket socket,
                                                          const HttpRequest& request,
                                                          const Settings& settings,
                                                          Listener& listener) {
  set_options(socket);
  auto session = std::make_shared<Session>(loop, std::move(socket), settings, listener);
  session->accept(request);
  return session;
}

void WebSocketOutput::keep_newest() {
  if (streams_) return;
  streams_ = std::make_unique<core::StreamCounters>();
  queue_.keep_newest(*streams_);
}

core::Outcome WebSocketOutput::add(std::span<const std::byte> message, std::uint8_t priority) {
  if (streams_) streams_->add(wire::decode_header(message.first<kHeaderSize>()));
  const std::uint64_t more = message.size() > queue_bytes_max_ ? message.size() : 0;
  queue_.set_bytes_max(queue_bytes_max_ + more);
  const bool taken = queue_.push(message, priority, replaced_);
  has_replaced_ = true;
  return taken ? core::Outcome::kDelivered : core::Outcome::kQueueFull;
}

std::optional<WebSocketOutput::Frame> WebSocketOutput::begin_frame() {
  if (queue_.empty()) return std::nullopt;
  std::size_t count = rest_ == 0 ? begin_message() : 0;
  count = add_rest(count);
  in_frame_ = true;
  return Frame{std::span(pieces_).first(count), rest_ == 0};
}

// Removes the header from the queue: from then on the rest of the message cannot be dropped.
std::size_t WebSocketOutput::begin_message() {
  // It spans at most two blocks.
  const std::size_t available = queue_.gather(std::span(pieces_).first<2>());
  std::size_t filled = 0;
  for (std::size_t i = 0; i < available && filled < kHeaderSize; ++i) {
    const auto part = pieces_[i].first(std::min(pieces_[i].size(), kHeaderSize - filled));
    std::ranges::copy(part, header_.begin() + static_cast<std::ptrdiff_t>(filled));
    filled += part.size();
  }
  queue_.consume(kHeaderSize);
  rest_ = wire::decode_header(header_).length - kHeaderSize;
  pieces_[0] = header_;
  return 1;
}

// Adds as much of the message as there are pieces. The following bytes belong to other messages.
std::size_t WebSocketOutput::add_rest(std::size_t count) {
  const std::size_t blocks_max = rest_ / core::ByteChain::kBlockBytes + 2;
  const std::size_t room = rest_ == 0 ? 0 : std::min(kFramePiecesMax - count, blocks_max);
  const std::size_t available = count + queue_.gather(std::span(pieces_).subspan(count, room));
  frame_body_ = 0;
  for (; count < available && rest_ > 0; ++count) {
    auto& piece = pieces_[count];
    piece = piece.first(std::min(piece.size(), rest_));
    frame_body_ += piece.size();
    rest_ -= piece.size();
  }
  return count;
}

void WebSocketOutput::end_frame() {
  queue_.consume(frame_body_);
  frame_body_ = 0;
  in_frame_ = false;
}

void WebSocketOutput::clear(core::LossCounts& lost) {
  queue_.clear(lost);
  rest_ = 0;
  frame_body_ = 0;
  in_frame_ = false;
}

void WebSocketOutput::add_replaced(const core::LossCounts& lost) {
  for (std::size_t i = 0; i < lost.size(); ++i) replaced_[i].add(lost[i]);
  has_replaced_ = true;
}

void WebSocketOutput::forget_replaced() {
  replaced_ = core::LossCounts{};
  has_replaced_ = false;
}

}  // namespace tims::io
