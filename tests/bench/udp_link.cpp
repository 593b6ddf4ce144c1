#include "tests/bench/udp_link.h"

#include <algorithm>

#include <sys/socket.h>

#include "tests/bench/addresses.h"
#include "tests/bench/blocking_socket.h"

namespace tims::bench {
namespace {

constexpr std::size_t kReadAhead = 1 << 20;

}  // namespace

UdpLink::UdpLink(const Plan& plan, std::size_t datagram, os::File socket)
    : socket_(std::move(socket)),
      datagram_(datagram),
      header_(message_header(plan)),
      gather_(plan.streaming() ? kGather : 0),
      out_(2 * kGather),
      in_(std::max(kReadAhead, 3 * (kHeaderSize + plan.payload))) {}

Result<UdpLink> UdpLink::open(const Plan& plan, std::size_t datagram) {
  auto socket = open_udp(plan.host + kClientPort);
  if (!socket) return socket.error();
  const auto to = udp_address(plan.endpoint);
  if (!to) return to.error();
  if (::connect(socket->get(), reinterpret_cast<const sockaddr*>(&*to), sizeof *to) != 0)
    return os::system_error("UDP to " + plan.endpoint);
  return UdpLink(plan, datagram, std::move(*socket));
}

bool UdpLink::send(std::span<const std::byte> payload) {
  header_.length = static_cast<std::uint32_t>(kHeaderSize + payload.size());
  if (header_.length > gather_ / 2) {
    flush();
    return send_trains(socket_, datagram_, std::as_bytes(std::span(&header_, 1)), payload);
  }
  append(&header_, sizeof header_);
  append(payload.data(), payload.size());
  if (filled_ >= gather_) flush();
  return true;
}

void UdpLink::append(const void* bytes, std::size_t size) {
  std::memcpy(&out_[filled_], bytes, size);
  filled_ += size;
}

void UdpLink::flush() {
  if (filled_ > 0) send_trains(socket_, datagram_, std::span(out_).first(filled_), {});
  filled_ = 0;
}

bool UdpLink::read_some(Duration timeout) {
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
