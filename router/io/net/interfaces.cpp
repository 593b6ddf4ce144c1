#include "router/io/net/interfaces.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include "os/clock.h"

namespace tims::io {
namespace {

constexpr unsigned kGroups =
    RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV6_IFADDR | RTMGRP_IPV4_ROUTE | RTMGRP_IPV6_ROUTE;
constexpr int kReadsPerTurn = 64;

using Bytes = std::span<const std::byte>;

template <typename Header>
Header header_of(Bytes bytes) {
  Header header{};
  std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof header));
  return header;
}

// What lies behind the first `size` bytes and their padding.
Bytes behind(Bytes bytes, std::size_t size) {
  return bytes.subspan(std::min<std::size_t>(NLMSG_ALIGN(size), bytes.size()));
}

// A radio that looks for networks says so as news of its interface, every few seconds.
bool is_radio_event(const nlmsghdr& header, Bytes content) {
  if (header.nlmsg_type != RTM_NEWLINK) return false;
  for (Bytes rest = behind(content, sizeof(ifinfomsg)); rest.size() >= sizeof(rtattr);) {
    const auto attribute = header_of<rtattr>(rest);
    if (attribute.rta_type == IFLA_WIRELESS) return true;
    rest = behind(rest, std::max<std::size_t>(attribute.rta_len, sizeof(rtattr)));
  }
  return false;
}

bool has_change(Bytes rest) {
  while (rest.size() >= sizeof(nlmsghdr)) {
    const auto header = header_of<nlmsghdr>(rest);
    const std::size_t size = std::clamp<std::size_t>(header.nlmsg_len, NLMSG_HDRLEN, rest.size());
    if (!is_radio_event(header, rest.first(size).subspan(NLMSG_HDRLEN))) return true;
    rest = behind(rest, size);
  }
  return false;
}

}  // namespace

InterfaceWatch::InterfaceWatch(Loop& loop, std::function<void()> on_change)
    : loop_(loop), on_change_(std::move(on_change)), timer_(loop, [this] { on_timer(); }) {}

Result<void> InterfaceWatch::start() {
  os::File file(::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!file) return os::system_error("watching interfaces: netlink socket");
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = kGroups;
  if (::bind(file.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return os::system_error("watching interfaces: netlink groups");
  file_ = std::move(file);
  watch_.emplace(loop_, file_.get(), [this](Ready) {
    if (take()) put_off();
  });
  return {};
}

// Whether anything has changed. Messages that the socket had no room for (ENOBUFS) count.
bool InterfaceWatch::take() {
  bool changed = false;
  std::array<std::byte, 32 << 10> buffer;
  for (int i = 0; i < kReadsPerTurn; ++i) {
    sockaddr_nl from{};
    socklen_t size = sizeof from;
    const ssize_t n = ::recvfrom(file_.get(), buffer.data(), buffer.size(), 0,
                                 reinterpret_cast<sockaddr*>(&from), &size);
    if (n < 0 && errno == ENOBUFS) {
      changed = true;
    } else if (n < 0) {
      break;
    } else if (from.nl_pid == 0) {  // the kernel; any process may write to this socket
      changed |= has_change(Bytes(buffer).first(static_cast<std::size_t>(n)));
    }
  }
  return changed;
}

void InterfaceWatch::put_off() {
  debounce_.on_change(os::now());
  timer_.set(debounce_.due());
}

void InterfaceWatch::on_timer() {
  debounce_.reset();
  on_change_();
}

}  // namespace tims::io
