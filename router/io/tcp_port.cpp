#include "router/io/tcp_port.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "os/clock.h"
#include "os/socket.h"
#include "router/io/subjects.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using core::Outcome;

// A socket that has room at all takes this much.
constexpr std::size_t kSmallMessageBytes = 2 << 10;

// Limit for one connection, before others have their turn.
constexpr std::size_t kQueueBytesPerTurn = 1 << 20;

std::span<const std::byte> bytes_of(const iovec& piece) {
  return {static_cast<const std::byte*>(piece.iov_base), piece.iov_len};
}

iovec piece_of(std::span<const std::byte> bytes) {
  return {const_cast<std::byte*>(bytes.data()), bytes.size()};  // sendmsg() only reads
}

// Many original clients switch lifesigns off; TCP keep-alive detects hosts that have disappeared.
constexpr os::KeepAlive kKeepAlive{.idle_s = 30, .probe_s = 10, .probes = 3};

// On a network, the maximum the system may buffer unsent: the rest waits in our own queue, where
// urgent messages overtake. Within this host it would only cost copies.
constexpr int kUnsentBytesMax = 256 << 10;

bool is_on_this_host(int socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return true;
  if (peer.ss_family == AF_UNIX) return true;  // the inner end of TLS
  if (peer.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer);
    return ntohl(v4.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
  }
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(peer).sin6_addr);
}

using Status = wire::StreamReader::Status;

using core::CloseReason;

constexpr std::size_t kTcpPortKeptBytes = 64 << 10;
// The router's own messages to a slow reader do not wait behind other messages: a lifesign must
// be answered, and the client may wait for the answer to a registration.
constexpr std::uint8_t kReplyPriority = 255;

// Up to this size, copying a message is cheaper than flushing all ports for it.
constexpr std::size_t kCopiedBytesMax = 4 << 10;

CloseReason reason_for(Status status) {
  return status == Status::kTooShort ? CloseReason::kTooShort : CloseReason::kTooLong;
}

}  // namespace

void TcpOutput::keep_newest() {
  if (streams_) return;
  streams_ = std::make_unique<core::StreamCounters>();
  queue_.keep_newest(*streams_);
}

Outcome TcpOutput::add(std::span<const std::byte> message, std::uint8_t priority) {
  if (piece_count_ == kPiecesMax) write_batch();
  if (failure_ != State::kIdle) return Outcome::kClientGone;
  if (streams_) streams_->add(wire::decode_header(message.first<kHeaderSize>()));
  if (!queue_.empty()) {
    may_have_lost_ = true;
    const bool taken = queue_.push(message, priority, lost_.replaced);
    return taken ? Outcome::kDelivered : Outcome::kQueueFull;
  }
  batch_bytes_ += message.size();
  if (piece_count_ > 0) {
    iovec& last = pieces_[piece_count_ - 1];
    if (static_cast<const std::byte*>(last.iov_base) + last.iov_len == message.data()) {
      last.iov_len += message.size();
      return Outcome::kDelivered;
    }
  }
  pieces_[piece_count_++] = piece_of(message);
  return Outcome::kDelivered;
}

void TcpOutput::write_batch() {
  if (piece_count_ == 0) return;
  if (queue_.reserve(batch_bytes_)) {
    const std::size_t written = send(std::span(pieces_).first(piece_count_));
    if (written < batch_bytes_) keep_rest(written);
  } else {
    write_singly();
  }
  piece_count_ = 0;
  batch_bytes_ = 0;
}

std::size_t TcpOutput::write_queue() {
  std::array<std::span<const std::byte>, kPiecesMax> waiting;
  std::array<iovec, kPiecesMax> pieces;
  std::size_t total = 0;
  while (total < kQueueBytesPerTurn && !queue_.empty()) {
    const std::size_t count = queue_.gather(waiting);
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; ++i) {
      pieces[i] = piece_of(waiting[i]);
      size += waiting[i].size();
    }
    const std::size_t written = send(std::span(pieces).first(count));
    queue_.consume(written);
    total += written;
    if (written < size) break;
  }
  return total;
}

TcpOutput::State TcpOutput::state() const {
  if (failure_ != State::kIdle) return failure_;
  return queue_.empty() ? State::kIdle : State::kWaiting;
}

void TcpOutput::forget_lost() {
  lost_ = Lost{};
  may_have_lost_ = false;
}

void TcpOutput::abandon() {
  for_each_message([this](std::span<const std::byte> message, const Header& header) {
    lost_.gone[classes_.of(header)].add(message.size());
    may_have_lost_ = true;
  });
  piece_count_ = 0;
  batch_bytes_ = 0;
  if (queue_.empty()) return;
  queue_.clear(lost_.gone);
  may_have_lost_ = true;
}

// Returns the number of bytes the socket accepted.
std::size_t TcpOutput::send(std::span<const iovec> pieces) {
  msghdr message{};
  message.msg_iov = const_cast<iovec*>(pieces.data());
  message.msg_iovlen = pieces.size();
  ssize_t n = 0;
  do {
    n = ::sendmsg(socket_, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (n < 0 && errno == EINTR);
  if (n >= 0) return static_cast<std::size_t>(n);
  if (errno != EAGAIN) failure_ = State::kBroken;
  return 0;
}

// There is not enough memory for all that the socket might not take: a message is begun only if
// its rest can be kept. One of a few bytes is taken by the socket as a whole, or not at all.
void TcpOutput::write_singly() {
  for_each_message([this](std::span<const std::byte> message, const Header& header) {
    if (failure_ != State::kIdle || !queue_.empty()) return keep(message, header, 0);
    if (message.size() > kSmallMessageBytes && !queue_.reserve(message.size())) {
      lost_.refused[classes_.of(header)].add(message.size());
      if (streams_) streams_->drop(header);
      may_have_lost_ = true;
      return;
    }
    const iovec piece = piece_of(message);
    const std::size_t written = send({&piece, 1});
    if (written < message.size()) keep(message, header, written);
  });
}

void TcpOutput::on_dropped(const core::LossCounts& lost) {
  for (std::size_t i = 0; i < lost.size(); ++i) lost_.replaced[i].add(lost[i]);
  may_have_lost_ = true;
  if (on_loss_) on_loss_();
}

void TcpOutput::give_up() {
  if (failure_ == State::kIdle) failure_ = State::kOutOfMemory;
  queue_.clear(lost_.gone);
  may_have_lost_ = true;
  if (on_loss_) on_loss_();
}

// Copies the unwritten messages of the batch into the queue. Precondition: the queue is empty.
void TcpOutput::keep_rest(std::size_t written) {
  for_each_message([&](std::span<const std::byte> message, const Header& header) {
    if (written >= message.size()) {
      written -= message.size();
      return;
    }
    keep(message, header, written);
    written = 0;
  });
}

void TcpOutput::keep(std::span<const std::byte> message, const Header& header,
                     std::size_t written) {
  may_have_lost_ = true;
  if (failure_ == State::kIdle) {
    if (written > 0) {
      if (queue_.push_rest(message.subspan(written), header)) return;
      failure_ = State::kOutOfMemory;
      lost_.gone[classes_.of(header)].add(message.size() - written);
      return;
    }
    if (queue_.push(message, classes_.waits_with(header), lost_.replaced)) return;
    lost_.refused[classes_.of(header)].add(message.size());
  } else {
    lost_.gone[classes_.of(header)].add(message.size());
  }
}

template <typename Visit>
void TcpOutput::for_each_message(Visit visit) const {
  for (std::size_t i = 0; i < piece_count_; ++i) {
    for (auto bytes = bytes_of(pieces_[i]); !bytes.empty();) {
      const Header header = wire::decode_header(bytes.first<kHeaderSize>());
      visit(bytes.first(header.length), header);
      bytes = bytes.subspan(header.length);
    }
  }
}

TcpConnection::TcpConnection(os::File its_socket, std::uint32_t message_max,
                             core::QueueShares& shares, std::uint64_t queue_bytes_max,
                             const core::PriorityClasses& classes,
                             std::function<void(TcpConnection&)> on_loss)
    : socket(std::move(its_socket)),
      reader(message_max),
      output(socket.get(), shares, queue_bytes_max, classes,
             [this, on_loss = std::move(on_loss)] { on_loss(*this); }) {
  os::set_option(socket.get(), IPPROTO_TCP, TCP_NODELAY, 1);
  if (!is_on_this_host(socket.get())) {
    os::set_option(socket.get(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, kUnsentBytesMax);
  }
  os::keep_alive(socket.get(), kKeepAlive);
  os::set_option(socket.get(), IPPROTO_TCP, TCP_INQ, 1);
}

TcpConnection::Read TcpConnection::read(std::span<std::byte> scratch) {
  const std::span<std::byte> room = reader.room();
  std::array<iovec, 2> pieces{iovec{room.data(), room.size()},
                              iovec{scratch.data(), scratch.size()}};
  const bool to_room = !room.empty();
  msghdr message{};
  message.msg_iov = pieces.data() + (to_room ? 0 : 1);
  message.msg_iovlen = to_room ? 2 : 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t n = ::recvmsg(socket.get(), &message, MSG_DONTWAIT);
  // The end of the connection counts as a byte that is left.
  if (n > 0 && os::control_value<int>(message, IPPROTO_TCP, TCP_CM_INQ) == 0) watch->all_taken();
  if (n == 0) return {ReadStatus::kClosed, {}};
  if (n < 0) {
    const bool later = errno == EAGAIN || errno == EINTR;
    return {later ? ReadStatus::kNothing : ReadStatus::kLost, {}};
  }
  const auto size = static_cast<std::size_t>(n);
  const std::size_t in_room = std::min(size, room.size());
  if (in_room > 0) reader.advance(in_room);
  return {ReadStatus::kSome, scratch.first(size - in_room)};
}

TcpPort::TcpPort(Loop& loop, core::Router& router, Log& log, core::QueueShares& shares,
                 const TcpPortSettings& settings)
    : loop_(loop),
      router_(router),
      shares_(shares),
      settings_(settings),
      acceptor_(
          loop, log,
          [this](os::File socket, const Visitor& visitor) { welcome(std::move(socket), visitor); }),
      half_messages_(settings.message_max),
      scratch_(std::make_unique_for_overwrite<Scratch>()),
      kept_(std::make_unique_for_overwrite<std::byte[]>(kTcpPortKeptBytes)) {
  set_queue_bytes_max(settings.queue_bytes_max);
}

void TcpPort::set_queue_bytes_max(std::uint64_t bytes) {
  settings_.queue_bytes_max = std::max<std::uint64_t>(bytes, settings_.message_max);
  connections_.for_each([&](TcpConnection& connection) {
    connection.output.set_queue_bytes_max(settings_.queue_bytes_max);
  });
}

void TcpPort::guard_by(TlsGate& gate, TlsGate::Entrance entrance, Who who) {
  acceptor_.guard_by(gate, std::move(entrance));
  who_ = std::move(who);
}

const Person* TcpPort::person(std::uint32_t token) const {
  const TcpConnection* connection = connections_.find(token);
  return connection == nullptr || !connection->person ? nullptr : &*connection->person;
}

void TcpPort::welcome(os::File socket, const Visitor& visitor) {
  const Time now = os::now();
  std::optional<Person> person;
  if (visitor.certificate) {
    person = who_(*visitor.certificate);
    if (!person) return;  // no member of the fleet
  }
  if (!router_.has_room(core::PortKind::kTcp)) make_room(now);
  const std::uint32_t token = connections_.next();
  const core::ClientId id = router_.connect(
      now, {.port = core::PortKind::kTcp,
            .token = token,
            .endpoint = std::string_view(visitor.peer),
            .lifesign = true,
            .subject = person ? person_subject(core::PortKind::kTcp, *person, visitor)
                              : visitor_subject(core::PortKind::kTcp, visitor)});
  if (id) {
    TcpConnection& connection = connections_.add(std::make_unique<TcpConnection>(
        std::move(socket), settings_.message_max, shares_, settings_.queue_bytes_max,
        router_.settings().classes, [this](TcpConnection& losing) { touch(losing); }));
    connection.id = id;
    connection.token = token;
    connection.person = std::move(person);
    connection.watch.emplace(loop_, connection.socket.get(),
                             [this, &connection](Ready ready) { on_ready(connection, ready); });
  }
  loop_.end_turn(now);
}

// Of the clients that have not sent anything yet, disconnects the oldest. Original programs
// register immediately after connecting.
void TcpPort::make_room(Time now) {
  TcpConnection* silent = nullptr;
  Time since = kNever;
  connections_.for_each([&](TcpConnection& connection) {
    const core::Client* client = router_.client(connection.id);
    if (client == nullptr || client->in.messages > 0 || client->connected_at >= since) return;
    silent = &connection;
    since = client->connected_at;
  });
  if (silent == nullptr) return;
  touch(*silent);
  forget(now, *silent, CloseReason::kTooManyClients);
}

// --- Port

Outcome TcpPort::deliver(Time now, const core::Receiver& to, const core::Message& message) {
  TcpConnection* connection = find(to.token, to.client);
  if (connection == nullptr || connection->closing) return Outcome::kClientGone;
  touch(*connection);
  shares_.set_now(now);
  return connection->output.add(message.bytes,
                                router_.settings().classes.waits_with(message.header));
}

void TcpPort::reply(Time now, const core::Receiver& to, const Header& header) {
  TcpConnection* connection = find(to.token, to.client);
  if (connection == nullptr || connection->closing) return;
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes);
  touch(*connection);
  shares_.set_now(now);
  connection->output.add(keep(bytes), kReplyPriority);
}

void TcpPort::close(const core::Receiver& client, CloseReason /*reason*/) {
  TcpConnection* connection = find(client.token, client.client);
  if (connection == nullptr) return;
  connection->closing = true;
  touch(*connection);
}

void TcpPort::keep_newest(const core::Receiver& client) {
  if (TcpConnection* connection = find(client.token, client.client))
    connection->output.keep_newest();
}

const core::StreamCounters* TcpPort::streams(std::uint32_t token) const {
  const TcpConnection* connection = connections_.find(token);
  return connection == nullptr ? nullptr : connection->output.streams();
}

void TcpPort::flush(Time now) {
  shares_.set_now(now);
  // NOLINTNEXTLINE(modernize-loop-convert): others are added that give memory to this one
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    TcpConnection* connection = touched_[i];
    connection->touched = false;
    connection->output.write_batch();
    settle(now, *connection);
  }
  touched_.clear();
  kept_size_ = 0;
}

std::uint64_t TcpPort::queued_bytes(std::uint32_t token) const {
  const TcpConnection* connection = connections_.find(token);
  return connection == nullptr ? 0 : connection->output.queued_bytes();
}

bool TcpPort::drained() const {
  bool waits = false;
  connections_.for_each([&](const TcpConnection& connection) {
    waits = waits || connection.output.state() == TcpOutput::State::kWaiting;
  });
  return !waits;
}

// --- Output

// Updates the connection after a write.
void TcpPort::settle(Time now, TcpConnection& connection) {
  report_losses(now, connection);
  switch (connection.output.state()) {
    case TcpOutput::State::kIdle:
      connection.watch->set(Interest::kReading);
      break;
    case TcpOutput::State::kWaiting:
      connection.watch->set(Interest::kBoth);
      break;
    case TcpOutput::State::kBroken:
      forget(now, connection, CloseReason::kConnectionLost);
      break;
    case TcpOutput::State::kOutOfMemory:
      forget(now, connection, CloseReason::kOutOfMemory);
      break;
  }
  if (connection.closing) erase(now, connection);
}

void TcpPort::write_more(TcpConnection& connection) {
  if (connection.output.write_queue() > 0) router_.on_progress(connection.id);
}

void TcpPort::report_losses(Time now, TcpConnection& connection) {
  const TcpOutput::Lost* lost = connection.output.lost();
  if (lost == nullptr) return;
  const auto report = [&](Outcome outcome, const core::LossCounts& losses) {
    router_.on_lost(now, core::PortKind::kTcp, connection.id, outcome, losses);
  };
  report(Outcome::kQueueReplaced, lost->replaced);
  report(Outcome::kQueueFull, lost->refused);
  report(Outcome::kClientGone, lost->gone);
  connection.output.forget_lost();
}

// The router no longer knows the client; the connection itself is removed when it is settled.
void TcpPort::forget(Time now, TcpConnection& connection, CloseReason reason) {
  if (connection.closing) return;
  connection.closing = true;
  router_.disconnect(now, connection.id, reason);
}

void TcpPort::erase(Time now, TcpConnection& connection) {
  connection.output.abandon();
  report_losses(now, connection);
  half_messages_.set(now, connection.token, 0);
  connections_.erase(connection.token);
}

// --- helpers

TcpConnection* TcpPort::find(std::uint32_t token, core::ClientId id) {
  TcpConnection* connection = connections_.find(token);
  return connection != nullptr && connection->id == id ? connection : nullptr;
}

void TcpPort::touch(TcpConnection& connection) {
  if (connection.touched) return;
  connection.touched = true;
  touched_.push_back(&connection);
}

// A copy that stays valid until the flush. When there is no room left, the collected data is
// written now.
std::span<std::byte> TcpPort::keep(std::span<const std::byte> bytes) {
  if (kept_size_ + bytes.size() > kTcpPortKeptBytes) {
    for (TcpConnection* connection : touched_) connection->output.write_batch();
    kept_size_ = 0;
  }
  const std::span copy(kept_.get() + kept_size_, bytes.size());
  std::ranges::copy(bytes, copy.begin());
  kept_size_ += bytes.size();
  return copy;
}

// --- input

void TcpPort::on_ready(TcpConnection& connection, Ready ready) {
  const Time now = os::now();
  shares_.set_now(now);
  touch(connection);
  if (ready.to_write) write_more(connection);
  if (ready.to_read) read_some(now, connection);
  loop_.end_turn(now);
}

void TcpPort::read_some(Time now, TcpConnection& connection) {
  const std::uint32_t token = connection.token;
  const core::ClientId id = connection.id;
  const TcpConnection::Read read = connection.read(scratch_->bytes);
  switch (read.status) {
    case TcpConnection::ReadStatus::kSome:
      take_messages(now, connection, read.chunk);
      bound_half_messages(now, token, id);
      break;
    case TcpConnection::ReadStatus::kNothing:
      break;
    case TcpConnection::ReadStatus::kClosed:
      on_end_of_input(now, connection, CloseReason::kPeerClosed);
      break;
    case TcpConnection::ReadStatus::kLost:
      on_end_of_input(now, connection, CloseReason::kConnectionLost);
      break;
  }
}

void TcpPort::take_messages(Time now, TcpConnection& connection, std::span<std::byte> chunk) {
  const std::uint32_t token = connection.token;
  const core::ClientId id = connection.id;
  for (;;) {
    const wire::StreamReader::Item item = connection.reader.next(chunk);
    if (item.status == Status::kNeedMore) return;
    if (item.status != Status::kMessage) return refuse_length(now, connection, item);
    take_message(now, connection, item);
    if (find(token, id) == nullptr || connection.closing) return;
    touch(connection);  // again: the ports may have been flushed
  }
}

void TcpPort::bound_half_messages(Time now, std::uint32_t token, core::ClientId id) {
  const TcpConnection* connection = find(token, id);
  if (connection == nullptr || connection->closing) return;
  half_messages_.set(now, token, connection->reader.pending());
  while (const auto victim = half_messages_.victim()) {
    half_messages_.set(now, victim->token, 0);
    TcpConnection& stalled = *connections_.find(victim->token);
    touch(stalled);
    on_end_of_input(now, stalled, CloseReason::kStalled);
  }
}

// A message in the scratch buffer stays valid until the flush; one assembled by the reader is
// valid only until its next call.
void TcpPort::take_message(Time now, TcpConnection& connection,
                           const wire::StreamReader::Item& item) {
  const std::byte* begin = item.message.data();
  const bool in_scratch = begin >= scratch_->bytes && begin < scratch_->bytes + kScratchBytes;
  const bool copied = !in_scratch && item.message.size() <= kCopiedBytesMax;
  core::Message message{item.header, copied ? keep(item.message) : item.message};
  if (!may_send(now, connection, message)) return;
  router_.on_message(now, connection.id, message);
  if (!in_scratch && !copied) loop_.end_turn(now);
}

bool TcpPort::may_send(Time now, TcpConnection& connection, const core::Message& message) {
  if (!connection.person) return true;
  const auto& settings = router_.settings();
  if (has(connection.person->rights,
          needed_for(SentMessage::of(message, settings), settings.widths)))
    return true;
  router_.on_lost(now, core::PortKind::kTcp, connection.id, Outcome::kNoRight,
                  message.header.priority, message.bytes.size());
  if (message.header.type > 0)
    reply(now, {.client = connection.id, .token = connection.token},
          wire::reply_to(message.header, type::kNotAvailable));
  return false;
}

void TcpPort::refuse_length(Time now, TcpConnection& connection,
                            const wire::StreamReader::Item& item) {
  router_.on_lost(now, core::PortKind::kTcp, connection.id, Outcome::kBadLength,
                  item.header.priority, kHeaderSize);
  forget(now, connection, reason_for(item.status));
}

void TcpPort::on_end_of_input(Time now, TcpConnection& connection, CloseReason reason) {
  const std::size_t pending = connection.reader.pending();
  if (pending > 0) {
    router_.on_lost(now, core::PortKind::kTcp, connection.id, Outcome::kIncomplete, 0, pending);
  }
  forget(now, connection, reason);
}

}  // namespace tims::io
