#include "components/devices/io/line.h"

#include <algorithm>

#include <arpa/inet.h>
#include <asm/termbits.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "components/devices/io/stream.h"
#include "components/devices/io/terminal.h"
#include "components/devices/io/transports.h"
#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr std::size_t kWaitingMax = 1 << 16;
constexpr Duration kSlice = std::chrono::milliseconds(1);  // transmission time of one write

// A driver opens the other end of the terminal as its serial line. If its rate differs from that of
// the emulated device, both receive garbled bytes; rate 0 matches any.
class EmulatedLine final : public StreamTransport {
 public:
  EmulatedLine(Terminal terminal, std::uint32_t baud, const std::string& link)
      : StreamTransport(terminal.take_own(), link, 0),
        terminal_(std::move(terminal)),
        rate_(baud) {}

  [[nodiscard]] Time next_timeout() const override {
    return waiting_.empty() ? StreamTransport::next_timeout() : pace_.next();
  }
  Result<void> receive(Time now, const Receive& receive) override {
    if (auto sent = send_waiting(now); !sent) return sent;
    return StreamTransport::receive(now, [&](const Arrival& arrival) {
      if (is_right_rate())
        receive(arrival);
      else
        receive({.bytes = noise(arrival.bytes), .first = arrival.first, .last = arrival.last});
    });
  }
  Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t) override {
    if (waiting_.size() + bytes.size() > kWaitingMax) return false;
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    if (auto sent = send_waiting(now); !sent) return sent.error();
    return true;
  }
  // Takes effect after the bytes already sent, as in a real device.
  void set_baud(std::uint32_t baud) override {
    if (waiting_.empty())
      rate_ = baud;
    else
      next_rate_ = baud;
  }

 private:
  Result<void> on_end() override { return {}; }

  [[nodiscard]] bool is_right_rate() const {
    termios2 settings{};
    return rate_ == 0 || ::ioctl(terminal_.other(), TCGETS2, &settings) != 0 ||
           settings.c_ospeed == rate_;
  }
  std::span<const std::byte> noise(std::span<const std::byte> bytes) {
    noise_.assign(bytes.begin(), bytes.end());
    for (std::byte& byte : noise_) byte = (byte << 1) ^ std::byte{0xE1};
    return noise_;
  }

  Result<void> send_waiting(Time now) {
    const std::size_t count = pace_.allowed(now, waiting_.size(), rate_);
    if (count > 0) {
      const auto piece = std::span<const std::byte>(waiting_).first(count);
      auto sent = StreamTransport::send(now, is_right_rate() ? piece : noise(piece), 0);
      if (!sent) return sent.error();
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (waiting_.empty() && next_rate_ != 0) rate_ = std::exchange(next_rate_, 0);
    return {};
  }

  Terminal terminal_;
  std::uint32_t rate_;
  std::uint32_t next_rate_ = 0;
  Pace pace_;
  std::vector<std::byte> waiting_;
  std::vector<std::byte> noise_;
};

// Serves one client at a time; a new client replaces the previous one, as with most scanners. The
// device starts again with each client, so that nobody gets the rest of what another one asked for.
class Listener final : public Transport {
 public:
  Listener(File listener, std::string description)
      : listener_(std::move(listener)), description_(std::move(description)) {}

  [[nodiscard]] int descriptor() const override {
    return client_ ? client_->descriptor() : listener_.get();
  }
  [[nodiscard]] std::string description() const override { return description_; }
  // The descriptor of the current client does not report a new client, so look periodically.
  [[nodiscard]] Time next_timeout() const override {
    return client_ ? std::min(next_look_, client_->next_timeout()) : next_look_;
  }

  Result<void> receive(Time now, const Receive& receive) override {
    constexpr Duration kLookEvery = std::chrono::milliseconds(20);
    next_look_ = now + kLookEvery;
    File next(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    const Arrival restart{.first = now, .last = now, .is_restart = true};
    if (next) {
      client_ = std::make_unique<Client>(std::move(next), description_, 0);
      is_lost_ = false;
      receive(restart);
    }
    if (client_ && (!client_->receive(now, receive) || is_lost_)) {
      client_.reset();
      receive(restart);
    }
    return {};
  }
  Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) override {
    if (!client_ || is_lost_) return false;
    const auto sent = client_->send(now, bytes, id);
    // It may be what is being received from, so it goes in receive().
    if (!sent) is_lost_ = true;
    return sent && *sent;
  }

 private:
  class Client final : public StreamTransport {
   public:
    using StreamTransport::StreamTransport;

   private:
    Result<void> on_end() override { return Error(Errc::kClosed, "it has gone"); }
  };

  File listener_;
  std::string description_;
  std::unique_ptr<Client> client_;
  bool is_lost_ = false;
  Time next_look_{};
};

Result<std::unique_ptr<Transport>> emulated_line(const DeviceAddress& address, std::uint32_t baud) {
  auto made = Terminal::make(address.place, 0);
  if (!made) return made.error();
  return std::unique_ptr<Transport>(
      std::make_unique<EmulatedLine>(std::move(*made), address.baud(baud), address.place));
}

Result<std::unique_ptr<Transport>> listen(const DeviceAddress& address) {
  File listener(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  // Its clients inherit these. A device has little memory, so that a client that reads slowly
  // misses data, and does not get what is seconds old.
  const int buffer = 1 << 16;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  ::setsockopt(listener.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(address.port);
  if (::inet_pton(AF_INET, address.place.c_str(), &where.sin_addr) != 1)
    return Error(Errc::kInvalidArgument, address.place + " is not an IPv4 address");
  if (::bind(listener.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0 ||
      ::listen(listener.get(), 4) != 0)
    return system_error(address.to_string());
  return std::unique_ptr<Transport>(
      std::make_unique<Listener>(std::move(listener), address.to_string()));
}

}  // namespace

std::size_t Pace::allowed(Time now, std::size_t waiting, std::uint32_t baud) {
  if (baud == 0 || waiting == 0) return waiting;
  if (is_idle_) carried_ = now;
  const Duration of_byte = line_time(1, baud);
  const std::size_t count = std::min(waiting, static_cast<std::size_t>((now - carried_) / of_byte));
  carried_ += line_time(count, baud);
  is_idle_ = count == waiting;
  next_ = carried_ + std::max(of_byte, std::min(kSlice, line_time(waiting - count, baud)));
  return count;
}

Result<std::unique_ptr<Transport>> open_line(const DeviceAddress& address, std::uint32_t baud) {
  if (address.kind == TransportKind::kPty) {
    const std::uint32_t bit_rate = address.can_bit_rate();
    auto line = emulated_line(address, baud);
    return line && bit_rate != 0 ? slcan_frames(std::move(*line), bit_rate) : std::move(line);
  }
  if (address.kind == TransportKind::kTcp) return listen(address);
  return open_transport(address, baud);
}

}  // namespace rack::device
