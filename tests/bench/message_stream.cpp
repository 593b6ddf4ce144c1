#include "tests/bench/message_stream.h"

#include <algorithm>

#include <sys/socket.h>

#include "tests/bench/addresses.h"
#include "tests/bench/tcp_bytes.h"

namespace tims::bench {
namespace {

constexpr std::size_t kReadAhead = 1 << 20;

Header header_of(const Plan& plan) {
  const Address sender = sender_address(plan.pair);
  const Address receiver = receiver_address(plan.pair, plan.index);
  return {.type = type::kData,
          .dest = plan.sender() ? receiver : sender,
          .src = plan.sender() ? sender : receiver};
}

}  // namespace

MessageStream::MessageStream(const Plan& plan, os::File socket, std::size_t gather)
    : socket_(std::move(socket)),
      header_(header_of(plan)),
      gather_(plan.streaming() ? gather : 0),
      out_(2 * gather),
      in_(std::max(kReadAhead, 3 * (kHeaderSize + plan.payload))) {}

bool MessageStream::send(std::span<const std::byte> payload) {
  header_.length = static_cast<std::uint32_t>(kHeaderSize + payload.size());
  if (header_.length > gather_ / 2) {
    flush();
    return write(std::as_bytes(std::span(&header_, 1)), payload);
  }
  append(&header_, sizeof header_);
  append(payload.data(), payload.size());
  if (filled_ >= gather_) flush();
  return true;
}

void MessageStream::append(const void* bytes, std::size_t size) {
  std::memcpy(&out_[filled_], bytes, size);
  filled_ += size;
}

void MessageStream::flush() {
  if (filled_ > 0) write(std::span(out_).first(filled_), {});
  filled_ = 0;
}

bool MessageStream::read_some(Duration timeout) {
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
