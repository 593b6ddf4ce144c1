// Net addresses: as the system's calls take them, and those of this host's interfaces: which others
// may reach, and when they change.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "os/file.h"
#include "router/io/loop.h"
#include "router/link/transport.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::io {

// --- as the system has them

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
// For one of the address's own.
inline SystemAddress system_address(const link::NetAddress& address) {
  return *system_address(address, address.is_v4() ? AF_INET : AF_INET6);
}

// Of one answer of getaddrinfo(), or getifaddrs(); port 0 unless of a known family.
link::NetAddress net_address(const addrinfo& info);
link::NetAddress net_address(const sockaddr& address);

// "10.9.1.1", "fe80::1%eth0"; nothing for names, and for interfaces that do not exist.
std::optional<link::NetAddress> numeric_address(const std::string& host, std::uint16_t port);

// --- of this host

// Many changes close together are one: it is due once they have ended, and not too late when they
// do not end.
class Debounce {
 public:
  static constexpr Duration kQuiet = std::chrono::milliseconds(50);    // after the last change
  static constexpr Duration kAtMost = std::chrono::milliseconds(300);  // after the first one

  void on_change(Time now) {
    if (due_ == kNever) first_ = now;
    due_ = std::min(now + kQuiet, first_ + kAtMost);
  }
  [[nodiscard]] Time due() const { return due_; }  // kNever: there was none
  void reset() { due_ = kNever; }

 private:
  Time first_{};
  Time due_ = kNever;
};

// Tells when addresses, carrier or routes of this host change.
class InterfaceWatch {
 public:
  // Called once for changes close together (Debounce), from the loop. There may have been none that
  // matters, as when a router renews an address: whoever's reaction is costly compares.
  InterfaceWatch(Loop& loop, std::function<void()> on_change);

  // From here on; once.
  Result<void> start();

 private:
  bool take();
  void put_off();
  void on_timer();

  Loop& loop_;
  std::function<void()> on_change_;
  os::File file_;
  std::optional<Watch> watch_;
  Timer timer_;
  Debounce debounce_;
};

// Where other hosts may reach a socket of this host. `local`: what the socket is bound to. Of a
// socket that is bound to all addresses, one for each address of an interface that has a carrier:
// not those of the link's own scope, which mean nothing elsewhere, and loopback only when there is
// nothing else.
std::vector<link::NetAddress> own_addresses(const link::NetAddress& local);

}  // namespace tims::io
