// Net addresses: in the form used by system calls, and those of this host's interfaces: which of
// them other hosts can reach, and when they change.
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

// --- system addresses

// Room for an address of either family.
struct SystemAddress {
  sockaddr_in6 storage{};
  socklen_t size = sizeof storage;

  [[nodiscard]] sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  [[nodiscard]] int family() const { return storage.sin6_family; }
  [[nodiscard]] link::NetAddress net_address() const;  // port 0 for an unknown family
};

// 0.0.0.0 or ::
bool is_any(const link::NetAddress& address);

// For a socket of this family; empty when it cannot reach the address (IPv6 from an IPv4 socket).
std::optional<SystemAddress> system_address(const link::NetAddress& address, int family);
// For a socket of the address's own family.
inline SystemAddress system_address(const link::NetAddress& address) {
  return *system_address(address, address.is_v4() ? AF_INET : AF_INET6);
}

// From a result of getaddrinfo() or getifaddrs(); port 0 for an unknown family.
link::NetAddress net_address(const addrinfo& info);
link::NetAddress net_address(const sockaddr& address);

// "10.9.1.1", "fe80::1%eth0"; empty for names and for interfaces that do not exist.
std::optional<link::NetAddress> numeric_address(const std::string& host, std::uint16_t port);

// --- addresses of this host

// Combines changes that are close together: due once they have ended, with an upper bound on the
// delay.
class Debounce {
 public:
  static constexpr Duration kQuiet = std::chrono::milliseconds(50);    // after the last change
  static constexpr Duration kAtMost = std::chrono::milliseconds(300);  // after the first one

  void on_change(Time now) {
    if (due_ == kNever) first_ = now;
    due_ = std::min(now + kQuiet, first_ + kAtMost);
  }
  [[nodiscard]] Time due() const { return due_; }  // kNever: no change
  void reset() { due_ = kNever; }

 private:
  Time first_{};
  Time due_ = kNever;
};

// Reports changes of addresses, carrier or routes of this host.
class InterfaceWatch {
 public:
  // Called from the loop, once for changes close together (Debounce). The changes may be
  // irrelevant, as when a router renews an address: an expensive reaction should compare first.
  InterfaceWatch(Loop& loop, std::function<void()> on_change);

  // Starts watching; call once.
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

// Addresses at which other hosts can reach a socket of this host. `local`: the address the socket
// is bound to. For a socket bound to all addresses, one for each address of an interface with
// carrier: without link-local ones, which are meaningless on other hosts, and loopback only when
// there is nothing else.
std::vector<link::NetAddress> own_addresses(const link::NetAddress& local);
// The same of a socket that is bound to all addresses, at most 256; the ports mean nothing.
std::vector<link::NetAddress> host_addresses();

}  // namespace tims::io
