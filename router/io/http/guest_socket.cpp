// Boost.Asio is compiled here; all other files include only its declarations.
#include "router/io/http/guest_socket.h"

#include <cerrno>
#include <utility>

#include <boost/asio/impl/src.hpp>
#include <boost/asio/post.hpp>
#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

namespace tims::io {
namespace {

constexpr int kHandlersPerTurn = 64;  // before others have their turn

namespace asio = boost::asio;

constexpr std::size_t kThrownAwayBytes = 1 << 20;  // discarded at a time

}  // namespace

void AsioGuest::wake() {
  if (std::exchange(awake_, true)) return;
  loop_.post([this] { run(); });
}

void AsioGuest::run() {
  int n = 0;
  while (n < kHandlersPerTurn && context_.poll_one() > 0) ++n;
  awake_ = false;
  if (n == kHandlersPerTurn) wake();
}

GuestSocket::GuestSocket(AsioGuest& guest, os::File socket)
    : guest_(guest), socket_(std::move(socket)) {
  watch_.emplace(
      guest.loop(), socket_.get(),
      [this](Ready) {
        go_on(read_);
        go_on(write_);
      },
      Interest::kChanges);
}

void GuestSocket::add(Transfer& transfer, asio::mutable_buffer piece) {
  transfer.pieces[transfer.count++] = {.iov_base = piece.data(), .iov_len = piece.size()};
  transfer.bytes += piece.size();
}

void GuestSocket::add(Transfer& transfer, asio::const_buffer piece) {
  add(transfer, asio::mutable_buffer(const_cast<void*>(piece.data()), piece.size()));
}

// --- one step: the result of the system call

ssize_t GuestSocket::read_step(Transfer& transfer) {
  msghdr message{};
  message.msg_iov = transfer.pieces.data();
  message.msg_iovlen = transfer.count;
  return ::recvmsg(socket_.get(), &message, MSG_DONTWAIT);
}

ssize_t GuestSocket::write_step(Transfer& transfer) {
  msghdr message{};
  message.msg_iov = transfer.pieces.data();
  message.msg_iovlen = transfer.count;
  const ssize_t n = ::sendmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (n > 0) bytes_written_ += static_cast<std::uint64_t>(n);
  return n;
}

ssize_t GuestSocket::finish_step(Transfer& transfer) {
  ssize_t n = 0;
  do {
    n = ::recv(socket_.get(), nullptr, transfer.bytes, MSG_DONTWAIT | MSG_TRUNC);
  } while (n > 0);
  return n;
}

std::uint64_t GuestSocket::bytes_acknowledged() const {
  int unacknowledged = 0;
  if (::ioctl(socket_.get(), SIOCOUTQ, &unacknowledged) != 0) return 0;
  return bytes_written_ - static_cast<std::uint64_t>(unacknowledged);
}

// --- transfers

void GuestSocket::go_on(Transfer& transfer) {
  if (!transfer.done) return;
  if (!socket_) return end(transfer, asio::error::bad_descriptor, 0);
  if (transfer.bytes == 0) return end(transfer, {}, 0);
  ssize_t n = 0;
  do {
    n = (this->*transfer.step)(transfer);
  } while (n < 0 && errno == EINTR);
  if (n > 0) return end(transfer, {}, static_cast<std::size_t>(n));
  if (n == 0) return end(transfer, asio::error::eof, 0);
  if (errno == EAGAIN) return;  // the watch reports when to continue
  end(transfer, {errno, boost::system::system_category()}, 0);
}

void GuestSocket::end(Transfer& transfer, error_code error, std::size_t bytes) {
  asio::post(guest_.context(), [done = std::move(*transfer.done), error, bytes]() mutable {
    std::move(done)(error, bytes);
  });
  transfer.done.reset();
  guest_.wake();
}

// --- the end

void GuestSocket::finish(Done done) {
  ::shutdown(socket_.get(), SHUT_WR);
  read_.step = &GuestSocket::finish_step;
  read_.bytes = kThrownAwayBytes;
  read_.done.emplace([done = std::move(done)](error_code error, std::size_t) mutable {
    std::move(done)(error == asio::error::eof ? error_code() : error, 0);
  });
  go_on(read_);
}

void GuestSocket::close() {
  watch_.reset();
  socket_.reset();
  for (Transfer* transfer : {&read_, &write_}) {
    if (transfer->done) end(*transfer, asio::error::operation_aborted, 0);
  }
}

void teardown(boost::beast::role_type, GuestSocket& socket, GuestSocket::error_code& error) {
  error = {};
  socket.close();
}

}  // namespace tims::io
