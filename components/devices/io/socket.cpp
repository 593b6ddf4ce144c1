// Transports to devices on the network: TCP connections and UDP datagrams.
#include "os/socket.h"

#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "components/devices/io/stamped.h"
#include "components/devices/io/stream.h"
#include "components/devices/io/transports.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr std::size_t kDatagramBytesMax = 1 << 16;
constexpr int kConnectMilliseconds = 1000;
constexpr int kReceiveBuffer = 4 << 20;  // half a turn of a 3D scanner

struct Place {
  sockaddr_storage address{};
  socklen_t size = 0;
};

Result<Place> find(const DeviceAddress& device, int type) {
  addrinfo hints{};
  hints.ai_socktype = type;
  hints.ai_flags = device.place.empty() ? AI_PASSIVE : 0;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(device.place.empty() ? nullptr : device.place.c_str(),
                                  std::to_string(device.port).c_str(), &hints, &found);
  if (error != 0) return Error(Errc::kSystem, device.to_string() + ": " + ::gai_strerror(error));
  Place place;
  place.size = found->ai_addrlen;
  std::memcpy(&place.address, found->ai_addr, found->ai_addrlen);
  ::freeaddrinfo(found);
  return place;
}

const sockaddr* raw(const Place& place) {
  return reinterpret_cast<const sockaddr*>(&place.address);
}
sockaddr* raw(Place& place) { return reinterpret_cast<sockaddr*>(&place.address); }

// A device that lost its power does not close the connection: enables keep-alive probes.
void notice_silence(int socket) {
  constexpr int kGoneMilliseconds = 1000;
  tims::os::set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  tims::os::keep_alive(socket, {.idle_s = 1, .probe_s = 1, .probes = 2});
  tims::os::set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kGoneMilliseconds);
}

Result<void> connect_within(int socket, const Place& place) {
  if (::connect(socket, raw(place), place.size) == 0) return {};
  if (errno != EINPROGRESS) return system_error("connect");
  pollfd wait{.fd = socket, .events = POLLOUT, .revents = 0};
  if (::poll(&wait, 1, kConnectMilliseconds) <= 0)
    return Error(Errc::kTimeout, "no answer within 1 s; check the power and cable of the device");
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  errno = error;
  if (error != 0) return system_error("connect");
  return {};
}

class TcpConnection final : public StreamTransport {
 public:
  TcpConnection(File socket, std::string description)
      : StreamTransport(std::move(socket), std::move(description), 0) {}

 private:
  Result<void> on_end() override {
    return Error(Errc::kClosed, "the device closed the connection");
  }
};

class UdpPort final : public Transport {
 public:
  UdpPort(File socket, std::optional<Place> peer, std::string description)
      : socket_(std::move(socket)),
        peer_(peer),
        description_(std::move(description)),
        bytes_(kDatagramBytesMax) {}

  [[nodiscard]] int descriptor() const override { return socket_.get(); }
  [[nodiscard]] std::string description() const override { return description_; }

  Result<void> receive(Time, const Receive& receive) override {
    constexpr int kAtOnce = 256;  // limits the time in this function when the port is flooded
    for (int i = 0; i < kAtOnce; ++i) {
      Place from;
      from.size = sizeof from.address;
      const auto message = receive_stamped(socket_.get(), bytes_, raw(from), from.size);
      if (!message) return message.error();
      if (!message->is_there) return {};
      if (!is_wanted(from)) continue;
      last_sender_ = from;
      receive({.bytes = std::span(bytes_).first(message->size),
               .first = message->when,
               .last = message->when,
               .id = port_of(from)});
    }
    return {};
  }

  Result<bool> send(Time, std::span<const std::byte> bytes, std::uint32_t) override {
    const std::optional<Place>& to = peer_ ? peer_ : last_sender_;
    if (!to) return false;
    const ssize_t size =
        ::sendto(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL, raw(*to), to->size);
    return size == static_cast<ssize_t>(bytes.size());
  }

 private:
  [[nodiscard]] bool is_wanted(const Place& from) const {
    if (!peer_) return true;
    if (from.address.ss_family != peer_->address.ss_family) return false;
    if (from.address.ss_family == AF_INET6)
      return std::memcmp(&reinterpret_cast<const sockaddr_in6*>(&from.address)->sin6_addr,
                         &reinterpret_cast<const sockaddr_in6*>(&peer_->address)->sin6_addr,
                         sizeof(in6_addr)) == 0;
    return reinterpret_cast<const sockaddr_in*>(&from.address)->sin_addr.s_addr ==
           reinterpret_cast<const sockaddr_in*>(&peer_->address)->sin_addr.s_addr;
  }

  static std::uint32_t port_of(const Place& place) {
    return ntohs(place.address.ss_family == AF_INET6
                     ? reinterpret_cast<const sockaddr_in6*>(&place.address)->sin6_port
                     : reinterpret_cast<const sockaddr_in*>(&place.address)->sin_port);
  }

  File socket_;
  std::optional<Place> peer_;
  std::optional<Place> last_sender_;
  std::string description_;
  std::vector<std::byte> bytes_;
};

Result<File> make_socket(const Place& place, int type) {
  File socket(::socket(place.address.ss_family, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return system_error("socket");
  return socket;
}

}  // namespace

Result<std::unique_ptr<Transport>> open_tcp(const DeviceAddress& address) {
  const auto place = find(address, SOCK_STREAM);
  if (!place) return place.error();
  auto socket = make_socket(*place, SOCK_STREAM);
  if (!socket) return socket.error();
  notice_silence(socket->get());
  if (auto connected = connect_within(socket->get(), *place); !connected)
    return Error(Errc::kSystem, address.to_string() + ": " + connected.error().detail());
  return std::unique_ptr<Transport>(
      std::make_unique<TcpConnection>(std::move(*socket), address.to_string()));
}

Result<std::unique_ptr<Transport>> open_udp(const DeviceAddress& address) {
  std::optional<Place> peer;
  if (!address.place.empty()) {
    const auto place = find(address, SOCK_DGRAM);
    if (!place) return place.error();
    peer = *place;
  }
  DeviceAddress here = address;
  here.place = peer && peer->address.ss_family == AF_INET6 ? "::" : "0.0.0.0";
  if (const auto local = address.options.find("local"); local != address.options.end())
    here.port = static_cast<std::uint16_t>(std::stoul(local->second));
  const auto own = find(here, SOCK_DGRAM);
  if (!own) return own.error();
  auto socket = make_socket(*own, SOCK_DGRAM);
  if (!socket) return socket.error();
  tims::os::set_option(socket->get(), SOL_SOCKET, SO_RCVBUF, kReceiveBuffer);
  ask_for_stamps(socket->get());
  if (::bind(socket->get(), raw(*own), own->size) != 0)
    return system_error("cannot use port " + std::to_string(here.port));
  return std::unique_ptr<Transport>(
      std::make_unique<UdpPort>(std::move(*socket), peer, address.to_string()));
}

}  // namespace rack::device
