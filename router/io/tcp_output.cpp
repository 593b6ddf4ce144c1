#include "router/io/tcp_output.h"

#include <cerrno>

#include <sys/socket.h>

#include "wire/header.h"

namespace tims::io {
namespace {

using core::Outcome;

// Of one connection, before others have their turn.
constexpr std::size_t kQueueBytesPerTurn = 1 << 20;

std::span<const std::byte> bytes_of(const iovec& piece) {
  return {static_cast<const std::byte*>(piece.iov_base), piece.iov_len};
}

iovec piece_of(std::span<const std::byte> bytes) {
  return {const_cast<std::byte*>(bytes.data()), bytes.size()};  // sendmsg() only reads
}

}  // namespace

Outcome TcpOutput::add(std::span<const std::byte> message, std::uint8_t priority) {
  if (piece_count_ == kPiecesMax) write_batch();
  if (failure_ != State::kIdle) return Outcome::kClientGone;
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
  const std::size_t written = send(std::span(pieces_).first(piece_count_));
  if (written < batch_bytes_) keep_rest(written);
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

// Returns how much the socket took.
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

// Copies the messages of the batch that were not written into the queue, which is empty.
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
      if (!queue_.push_rest(message.subspan(written), header)) failure_ = State::kOutOfMemory;
      return;
    }
    if (queue_.push(message, core::PriorityClasses::waits_with(header), lost_.replaced)) return;
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

}  // namespace tims::io
