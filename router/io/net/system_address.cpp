#include "router/io/net/system_address.h"

#include <cstring>

namespace tims::io {

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

}  // namespace tims::io
