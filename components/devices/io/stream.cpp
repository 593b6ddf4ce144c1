#include "components/devices/io/stream.h"

#include <cerrno>

#include <sys/socket.h>
#include <unistd.h>

#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::size_t kReadBytes = 1 << 16;
constexpr std::size_t kWaitingBytesMax = 1 << 16;
constexpr Duration kStreamTryAgain = std::chrono::milliseconds(2);

Error gone(const char* what) {
  return {Errc::kSystem, "the device is gone: " + tims::os::system_error(what).detail()};
}

// A lost connection must not end the program by SIGPIPE.
ssize_t write_some(int file, std::span<const std::byte> bytes) {
  const ssize_t size = ::send(file, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return size < 0 && errno == ENOTSOCK ? ::write(file, bytes.data(), bytes.size()) : size;
}

}  // namespace

StreamTransport::StreamTransport(tims::os::File file, std::string description, std::uint32_t baud)
    : file_(std::move(file)),
      baud_(baud),
      description_(std::move(description)),
      bytes_(kReadBytes) {
  waiting_.reserve(kWaitingBytesMax);
}

Result<void> StreamTransport::receive(Time now, const Receive& receive) {
  if (auto written = write_waiting(now); !written) return written;
  for (;;) {
    const ssize_t size = ::read(file_.get(), bytes_.data(), bytes_.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return {};
    if (size < 0) return gone("read");
    if (size == 0) return on_end();
    const auto count = static_cast<std::size_t>(size);
    const Duration took = baud_ == 0 ? Duration(0) : line_time(count, baud_);
    receive({.bytes = std::span(bytes_).first(count), .first = now - took, .last = now});
    if (count < bytes_.size()) return {};
  }
}

Result<bool> StreamTransport::send(Time now, std::span<const std::byte> bytes, std::uint32_t) {
  // A piece may be larger than that, such as a picture, if nothing else waits.
  if (!waiting_.empty() && waiting_.size() + bytes.size() > kWaitingBytesMax) return false;
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  if (auto written = write_waiting(now); !written) return written.error();
  return true;
}

Result<void> StreamTransport::write_waiting(Time now) {
  while (!waiting_.empty()) {
    const ssize_t size = write_some(file_.get(), waiting_);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno != EAGAIN) return gone("write");
    if (size <= 0) break;
    waiting_.erase(waiting_.begin(), waiting_.begin() + size);
  }
  next_try_ = waiting_.empty() ? tims::kNever : now + kStreamTryAgain;
  return {};
}

}  // namespace rack::device
