// Net addresses as the system's calls take them.
#pragma once

#include <optional>
#include <string>

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "router/link/transport.h"

namespace tims::io {

// Room for an address of either family.
struct SystemAddress {
  sockaddr_in6 storage{};
  socklen_t size = sizeof storage;

  [[nodiscard]] sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  [[nodiscard]] int family() const { return storage.sin6_family; }
  [[nodiscard]] link::NetAddress net_address() const;  // port 0 unless of a known family
};

// For a socket of this family; nothing when that cannot reach it (IPv6 from an IPv4 socket).
std::optional<SystemAddress> system_address(const link::NetAddress& address, int family);

// Of one answer of getaddrinfo(), or getifaddrs(); port 0 unless of a known family.
link::NetAddress net_address(const addrinfo& info);
link::NetAddress net_address(const sockaddr& address);

// "10.9.1.1", "fe80::1%eth0"; nothing for names, and for interfaces that do not exist.
std::optional<link::NetAddress> numeric_address(const std::string& host, std::uint16_t port);

}  // namespace tims::io
