#include "security/relay/tls_relay.h"

#include <array>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/socket.h"

namespace tims::security {
namespace {

// RFC 8446, section 5.1: the type of a record with a handshake.
constexpr std::byte kTlsHandshake{0x16};
// After one side has ended, the other one has this long to do so, too.
constexpr Duration kEndingTime = std::chrono::seconds(2);
// The more is on its way, the longer urgent messages wait.
constexpr int kUnsentBytesMax = 128 << 10;
constexpr int kInnerBytesMax = 128 << 10;

void set_options(int socket) {
  os::set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  os::set_option(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, kUnsentBytesMax);
  os::keep_alive(socket, {.idle_s = 30, .probe_s = 10, .probes = 3});
}

enum class Read : std::uint8_t { kSome, kNothing, kEnd };
Read read_some(int socket, std::span<std::byte> room, std::size_t& size) {
  const ssize_t n = ::recv(socket, room.data(), room.size(), MSG_DONTWAIT);
  size = n > 0 ? static_cast<std::size_t>(n) : 0;
  if (n > 0) return Read::kSome;
  return n < 0 && (errno == EAGAIN || errno == EINTR) ? Read::kNothing : Read::kEnd;
}

}  // namespace

void TlsRelay::Waiting::add(View more) {
  if (empty()) {
    bytes.clear();
    sent = 0;
  }
  bytes.insert(bytes.end(), more.begin(), more.end());
}

bool TlsRelay::Waiting::flush(int socket) {
  while (!empty()) {
    const ssize_t n =
        ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno == EAGAIN;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

TlsRelay::TlsRelay(Relayed what, Time deadline) : what_(std::move(what)), deadline_(deadline) {
  set_options(what_.socket.get());
  const bool begins = what_.tls && what_.tls->side() == TlsSettings::Side::kClient;
  if (begins) begin_tls();
}

short TlsRelay::outer_events() const {
  const bool reads = !outer_ended_ && to_inner_.empty();
  return static_cast<short>((reads ? POLLIN : 0) | (to_outer_.empty() ? 0 : POLLOUT));
}

short TlsRelay::inner_events() const {
  const bool opened = state_ == State::kOpen || state_ == State::kEnding;
  const bool reads = opened && !inner_ended_ && to_outer_.empty();
  return static_cast<short>((reads ? POLLIN : 0) | (to_inner_.empty() ? 0 : POLLOUT));
}

void TlsRelay::work(Time now) {
  if (state_ == State::kFirstByte) look_at_first_byte();
  if (state_ != State::kFirstByte && state_ != State::kOver) exchange(now);
}

// A silent client that may speak in the clear is an original that waits.
void TlsRelay::on_deadline() {
  if (state_ == State::kFirstByte && what_.may_be_plain) return hand_on();
  if (state_ == State::kFirstByte || state_ == State::kHandshake)
    return refuse("it has not completed the TLS handshake in time");
  state_ = State::kOver;
}

// --- the beginning

void TlsRelay::look_at_first_byte() {
  std::byte first{};
  const ssize_t n = ::recv(what_.socket.get(), &first, 1, MSG_PEEK | MSG_DONTWAIT);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) {
    state_ = State::kOver;
    return;
  }
  if (first == kTlsHandshake && what_.tls) return begin_tls();
  if (what_.may_be_plain) return hand_on();
  refuse(first == kTlsHandshake ? "it speaks TLS, and this port has no keys"
                                : "it speaks in the clear, and only TLS is allowed from there");
}

void TlsRelay::begin_tls() {
  tls_ = std::make_unique<TlsSession>(*what_.tls);
  chunk_.resize(kChunkBytes);
  state_ = State::kHandshake;
  if (what_.tls->side() == TlsSettings::Side::kClient) tls_->feed({});
  encrypted();
}

void TlsRelay::hand_on() {
  state_ = State::kOver;
  what_.on_open({.socket = std::move(what_.socket)});
}

void TlsRelay::refuse(const std::string& reason) {
  if (tls_) {
    encrypted();  // the alert that names the reason
    (void)to_outer_.flush(what_.socket.get());
  }
  state_ = State::kOver;
  what_.on_refused(reason);
}

bool TlsRelay::make_inner() {
  if (what_.plain) {
    inner_ = std::move(what_.plain);
    set_options(inner_.get());
    return true;
  }
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return false;
  for (const int end : ends) os::set_option(end, SOL_SOCKET, SO_SNDBUF, kInnerBytesMax);
  inner_ = os::File(ends[0]);
  what_.plain = os::File(ends[1]);
  return true;
}

void TlsRelay::open() {
  if (!make_inner()) return refuse("no free file descriptor");
  state_ = State::kOpen;
  deadline_ = kNever;
  chain_ = tls_->peer_chain();
  what_.on_open({.socket = std::move(what_.plain), .is_tls = true, .chain = chain_});
}

// --- the bytes

void TlsRelay::exchange(Time now) {
  constexpr int kChunksPerTurn = 4;  // before others have their turn
  for (int i = 0; i < kChunksPerTurn; ++i) {
    const bool received = receive();
    const bool taken = take_from_inner();
    if (state_ == State::kOver) return;
    if (!to_outer_.flush(outer()) || (inner_ && !to_inner_.flush(inner()))) {
      state_ = State::kOver;
      return;
    }
    if (!received && !taken) break;
  }
  if (outer_ended_ || inner_ended_) end_when_both_have(now);
}

// What has been sent before an end still arrives.
void TlsRelay::end_when_both_have(Time now) {
  if (state_ == State::kOpen) {
    state_ = State::kEnding;
    deadline_ = now + kEndingTime;
  }
  if (outer_ended_ && to_inner_.empty() && inner_) ::shutdown(inner(), SHUT_WR);
  if (inner_ended_ && to_outer_.empty()) ::shutdown(outer(), SHUT_WR);
  if (outer_ended_ && inner_ended_ && to_outer_.empty() && to_inner_.empty()) state_ = State::kOver;
}

// From the network. True: something has come.
bool TlsRelay::receive() {
  if (outer_ended_ || !to_inner_.empty()) return false;
  std::size_t size = 0;
  const Read read = read_some(what_.socket.get(), chunk_, size);
  if (read == Read::kNothing) return false;
  if (read == Read::kEnd) {
    outer_ended_ = true;
    if (state_ == State::kHandshake) refuse("the connection has ended during the TLS handshake");
    return false;
  }
  const bool shaking_hands = state_ == State::kHandshake;
  tls_->feed(View(chunk_).first(size));
  if (shaking_hands && tls_->state() == TlsSession::State::kOpen) open();
  while (state_ != State::kOver && (size = tls_->read(chunk_)) > 0)
    to_inner_.add(View(chunk_).first(size));
  encrypted();
  if (tls_->state() == TlsSession::State::kFailed && state_ == State::kHandshake) {
    refuse(tls_->error());
  } else if (tls_->state() == TlsSession::State::kFailed ||
             tls_->state() == TlsSession::State::kClosed) {
    outer_ended_ = true;
  }
  return true;
}

// From the program inside. True: something has come.
bool TlsRelay::take_from_inner() {
  const bool reads = state_ == State::kOpen || state_ == State::kEnding;
  if (!reads || inner_ended_ || !to_outer_.empty()) return false;
  std::size_t size = 0;
  const Read read = read_some(inner_.get(), chunk_, size);
  if (read == Read::kNothing) return false;
  if (read == Read::kEnd) {
    inner_ended_ = true;
    tls_->close();
  } else {
    tls_->write(View(chunk_).first(size));
  }
  encrypted();
  return read == Read::kSome;
}

void TlsRelay::encrypted() {
  for (Bytes bytes = tls_->take(); !bytes.empty(); bytes = tls_->take()) to_outer_.add(bytes);
}

}  // namespace tims::security
