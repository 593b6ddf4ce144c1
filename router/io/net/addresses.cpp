#include "router/io/net/addresses.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <span>

#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "os/clock.h"

namespace tims::io {
namespace {

using Bytes = std::span<const std::byte>;
using link::NetAddress;

constexpr unsigned kGroups =
    RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV6_IFADDR | RTMGRP_IPV4_ROUTE | RTMGRP_IPV6_ROUTE;
constexpr int kReadsPerTurn = 64;

template <typename Header>
Header header_of(Bytes bytes) {
  Header header{};
  std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof header));
  return header;
}

// The bytes after the first `size` bytes and their padding.
Bytes behind(Bytes bytes, std::size_t size) {
  return bytes.subspan(std::min<std::size_t>(NLMSG_ALIGN(size), bytes.size()));
}

// A radio that scans for networks reports it as a change of its interface, every few seconds.
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

bool is_any(const NetAddress& address) {
  const auto& ip = address.ip;
  const auto last = address.is_v4() ? ip.begin() + 12 : ip.begin();
  return std::all_of(last, ip.end(), [](std::uint8_t byte) { return byte == 0; });
}

// --- system addresses

using link::NetAddress;

NetAddress SystemAddress::net_address() const {
  if (family() == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &storage, sizeof v4);
    std::array<std::uint8_t, 4> ip{};
    std::memcpy(ip.data(), &v4.sin_addr, ip.size());
    return NetAddress::v4(ip[0], ip[1], ip[2], ip[3], ntohs(v4.sin_port));
  }
  NetAddress address;
  if (family() != AF_INET6) return address;
  std::memcpy(address.ip.data(), &storage.sin6_addr, address.ip.size());
  address.port = ntohs(storage.sin6_port);
  address.scope = storage.sin6_scope_id;
  return address;
}

std::optional<SystemAddress> system_address(const NetAddress& address, int family) {
  SystemAddress result;
  if (family == AF_INET) {
    if (!address.is_v4()) return std::nullopt;
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(address.port);
    std::memcpy(&v4.sin_addr, address.ip.data() + 12, sizeof v4.sin_addr);
    std::memcpy(&result.storage, &v4, sizeof v4);
    result.size = sizeof v4;
    return result;
  }
  result.storage.sin6_family = AF_INET6;
  result.storage.sin6_port = htons(address.port);
  result.storage.sin6_scope_id = address.scope;
  std::memcpy(&result.storage.sin6_addr, address.ip.data(), address.ip.size());
  return result;
}

NetAddress net_address(const addrinfo& info) { return net_address(*info.ai_addr); }

NetAddress net_address(const sockaddr& address) {
  const std::size_t size = address.sa_family == AF_INET    ? sizeof(sockaddr_in)
                           : address.sa_family == AF_INET6 ? sizeof(sockaddr_in6)
                                                           : sizeof address.sa_family;
  SystemAddress copy;
  std::memcpy(&copy.storage, &address, size);
  return copy.net_address();
}

std::optional<NetAddress> numeric_address(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return std::nullopt;
  NetAddress address = net_address(*found);
  ::freeaddrinfo(found);
  address.port = port;
  return address;
}

// --- addresses of this host

InterfaceWatch::InterfaceWatch(Loop& loop, std::function<void()> on_change)
    : loop_(loop), on_change_(std::move(on_change)), timer_(loop, [this] { on_timer(); }) {}

Result<void> InterfaceWatch::start() {
  os::File file(::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!file) return os::system_error("cannot watch interfaces: netlink socket");
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = kGroups;
  if (::bind(file.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return os::system_error("cannot watch interfaces: netlink groups");
  file_ = std::move(file);
  watch_.emplace(loop_, file_.get(), [this](Ready) {
    if (take()) put_off();
  });
  return {};
}

// True when anything has changed. Messages lost by the socket (ENOBUFS) count as a change.
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
    } else if (from.nl_pid == 0) {  // from the kernel; any process may write to this socket
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

std::vector<NetAddress> own_addresses(const NetAddress& local) {
  if (!is_any(local)) return {local};
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, ::freeifaddrs);
  std::vector<NetAddress> outside;
  std::vector<NetAddress> loopback;
  for (const ifaddrs* at = list; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || (at->ifa_flags & IFF_RUNNING) == 0) continue;
    const int family = at->ifa_addr->sa_family;
    if (family != AF_INET && (family != AF_INET6 || local.is_v4())) continue;
    NetAddress address = net_address(*at->ifa_addr);
    address.port = local.port;
    if (address.scope != 0) continue;
    ((at->ifa_flags & IFF_LOOPBACK) != 0 ? loopback : outside).push_back(address);
  }
  std::vector<NetAddress>& found = outside.empty() ? loopback : outside;
  std::ranges::sort(found);
  return found;
}

std::vector<NetAddress> host_addresses() {
  constexpr std::size_t kAddressesMax = 256;
  std::vector<NetAddress> addresses = own_addresses({.port = 1});
  if (addresses.size() > kAddressesMax) addresses.resize(kAddressesMax);
  return addresses;
}

}  // namespace tims::io
