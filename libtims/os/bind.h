// Binds a socket also to an address that this host does not have yet: a router may be started
// before the interface is there.
#pragma once

#include <cerrno>

#include <netinet/in.h>
#include <sys/socket.h>

namespace tims::os {

enum class Bound { kNo, kYes, kAddressNotHereYet };  // kNo: errno says why

inline Bound bind_even_early(int socket, const sockaddr* address, socklen_t size) {
  if (::bind(socket, address, size) == 0) return Bound::kYes;
  if (errno != EADDRNOTAVAIL) return Bound::kNo;
  const int yes = 1;
  address->sa_family == AF_INET6
      ? ::setsockopt(socket, IPPROTO_IPV6, IPV6_FREEBIND, &yes, sizeof yes)
      : ::setsockopt(socket, IPPROTO_IP, IP_FREEBIND, &yes, sizeof yes);
  return ::bind(socket, address, size) == 0 ? Bound::kAddressNotHereYet : Bound::kNo;
}

}  // namespace tims::os
