#include "tests/bench/tcp_link.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include "libtims/wire/router_commands.h"
#include "tests/bench/addresses.h"
#include "tests/bench/tcp_bytes.h"
#include "tests/support/tcp_socket.h"

namespace tims::bench {
namespace {

constexpr std::size_t kGather = 64 << 10;
constexpr std::size_t kReadAhead = 1 << 20;

Header header_of(const Plan& plan) {
  const Address sender = sender_address(plan.pair);
  const Address receiver = receiver_address(plan.pair, plan.index);
  return {.type = type::kData,
          .dest = plan.sender() ? receiver : sender,
          .src = plan.sender() ? sender : receiver};
}

}  // namespace

Result<TcpLink> TcpLink::open(const Plan& plan, Between between) {
  auto socket = test::connect_tcp(plan.endpoint, std::chrono::seconds(5));
  if (!socket) return socket.error();
  make_blocking(*socket);
  TcpLink link(plan, between, std::move(*socket));
  auto registered = link.register_mailbox(link.header_.src);
  if (!registered) return registered.error();
  return link;
}

TcpLink::TcpLink(const Plan& plan, Between between, os::File socket)
    : socket_(std::move(socket)),
      between_(between),
      header_(header_of(plan)),
      gather_(plan.streaming() ? kGather : 0),
      out_(2 * kGather),
      in_(std::max(kReadAhead, 3 * (kHeaderSize + plan.payload))) {}

// As the original's C library: no watchdog, then the mailbox, then one answer.
Result<void> TcpLink::register_mailbox(Address address) {
  const auto request = registration_of(address);
  if (!write_all(socket_, request)) return os::system_error("register");
  Header answer;
  if (!read_exactly(socket_, std::as_writable_bytes(std::span(&answer, 1))))
    return os::system_error("register");
  if (answer.type != type::kOk) return Error(Errc::kAddressInUse, address.to_string());
  return {};
}

bool TcpLink::send(std::span<const std::byte> payload) {
  header_.length = static_cast<std::uint32_t>(kHeaderSize + payload.size());
  if (header_.length > gather_ / 2) {
    flush();
    return write_both(socket_, std::as_bytes(std::span(&header_, 1)), payload);
  }
  append(&header_, sizeof header_);
  append(payload.data(), payload.size());
  if (filled_ >= gather_) flush();
  return true;
}

void TcpLink::append(const void* bytes, std::size_t size) {
  std::memcpy(&out_[filled_], bytes, size);
  filled_ += size;
}

void TcpLink::flush() {
  if (filled_ > 0) write_all(socket_, std::span(out_).first(filled_));
  filled_ = 0;
}

bool TcpLink::read_some(Duration timeout) {
  constexpr std::size_t kRoomMin = 64 << 10;
  if (timeout != timeout_) {
    set_read_timeout(socket_, timeout);
    timeout_ = timeout;
  }
  if (in_.size() - end_ < kRoomMin) {
    std::memmove(in_.data(), &in_[at_], end_ - at_);
    end_ -= at_;
    at_ = 0;
  }
  const ssize_t n = ::recv(socket_.get(), &in_[end_], in_.size() - end_, 0);
  if (n <= 0) return false;
  end_ += static_cast<std::size_t>(n);
  return true;
}

}  // namespace tims::bench
