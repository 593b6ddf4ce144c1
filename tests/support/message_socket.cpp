#include "tests/support/message_socket.h"

#include <array>
#include <cerrno>

#include <sys/socket.h>

#include "tests/support/tcp_socket.h"

namespace tims::test {

void MessageSocket::send(std::span<const std::byte> bytes) {
  unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
  on_writable();
}

void MessageSocket::on_writable() {
  std::size_t sent = 0;
  while (sent < unsent_.size()) {
    const ssize_t n = ::send(fd(), unsent_.data() + sent, unsent_.size() - sent, MSG_NOSIGNAL);
    if (n >= 0) {
      sent += static_cast<std::size_t>(n);
    } else if (errno == EAGAIN) {
      break;
    } else if (errno != EINTR) {
      sent = unsent_.size();  // the error is reported by the next read
    }
  }
  unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(sent));
}

void MessageSocket::on_readable(std::vector<OwnedMessage>& messages) {
  std::array<std::byte, 64 << 10> buffer;
  while (is_there()) {
    const ssize_t n = ::recv(fd(), buffer.data(), buffer.size(), 0);
    if (n > 0) {
      take(std::span(buffer).first(static_cast<std::size_t>(n)), messages);
    } else if (n == 0) {
      peer_ = Peer::kClosed;
    } else if (errno == EAGAIN) {
      return;
    } else if (errno != EINTR) {
      peer_ = Peer::kReset;
    }
  }
}

void MessageSocket::take(std::span<std::byte> chunk, std::vector<OwnedMessage>& messages) {
  using Status = wire::StreamReader::Status;
  for (;;) {
    const wire::StreamReader::Item item = reader_.next(chunk);
    if (item.status == Status::kNeedMore) return;
    if (item.status != Status::kMessage) {
      peer_ = Peer::kNonsense;
      return;
    }
    messages.push_back(copy_of({item.header, item.message.subspan(kHeaderSize)}));
  }
}

void MessageSocket::shut_down_sending() const { ::shutdown(fd(), SHUT_WR); }

void MessageSocket::close_with_reset() {
  test::close_with_reset(file_);
  peer_ = Peer::kClosed;
}

}  // namespace tims::test
