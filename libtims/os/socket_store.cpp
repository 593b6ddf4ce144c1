#include "os/socket_store.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/environment.h"
#include "os/service_manager.h"
#include "os/socket.h"

namespace tims::os {
namespace {

constexpr int kFirstInherited = 3;  // SD_LISTEN_FDS_START
constexpr int kInheritedMax = 64;

struct OwnAddress {
  sockaddr_storage address{};
  socklen_t size = sizeof address;

  explicit OwnAddress(int socket) {
    if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) size = 0;
  }
  template <typename Address>
  [[nodiscard]] const Address& as() const {
    return reinterpret_cast<const Address&>(address);
  }
};

int type_of(int socket) {
  int type = 0;
  socklen_t size = sizeof type;
  ::getsockopt(socket, SOL_SOCKET, SO_TYPE, &type, &size);
  return type;
}

std::string host_and_port(int family, const void* host, in_port_t port) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(family, host, text.data(), text.size());
  return std::string(text.data()) + "-" + std::to_string(ntohs(port));
}

// Also the name of the socket at the manager, where it must not contain a colon.
std::string name_of(int socket) {
  const OwnAddress bound(socket);
  std::string name = type_of(socket) == SOCK_DGRAM ? "udp-" : "tcp-";
  switch (bound.address.ss_family) {
    case AF_UNIX:
      name = "unix-" + std::string(bound.as<sockaddr_un>().sun_path);
      break;
    case AF_INET: {
      const auto& address = bound.as<sockaddr_in>();
      name += host_and_port(AF_INET, &address.sin_addr, address.sin_port);
      break;
    }
    case AF_INET6: {
      const auto& address = bound.as<sockaddr_in6>();
      name += host_and_port(AF_INET6, &address.sin6_addr, address.sin6_port);
      break;
    }
    default:
      break;
  }
  std::ranges::replace(name, ':', '.');
  return name;
}

// Not byte by byte: systems fill what follows the address differently.
bool same_address(const sockaddr& one, const sockaddr& other) {
  if (one.sa_family != other.sa_family) return false;
  switch (one.sa_family) {
    case AF_UNIX:
      return std::strncmp(reinterpret_cast<const sockaddr_un&>(one).sun_path,
                          reinterpret_cast<const sockaddr_un&>(other).sun_path,
                          sizeof sockaddr_un::sun_path) == 0;
    case AF_INET: {
      const auto& a = reinterpret_cast<const sockaddr_in&>(one);
      const auto& b = reinterpret_cast<const sockaddr_in&>(other);
      return a.sin_port == b.sin_port && a.sin_addr.s_addr == b.sin_addr.s_addr;
    }
    case AF_INET6: {
      const auto& a = reinterpret_cast<const sockaddr_in6&>(one);
      const auto& b = reinterpret_cast<const sockaddr_in6&>(other);
      return a.sin6_port == b.sin6_port && a.sin6_scope_id == b.sin6_scope_id &&
             std::memcmp(&a.sin6_addr, &b.sin6_addr, sizeof a.sin6_addr) == 0;
    }
    default:
      return false;
  }
}

int number_in(const char* name) {
  const std::string text = environment(name);
  int number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

SocketStore::SocketStore(ServiceManager& manager, std::vector<File> inherited)
    : manager_(manager), inherited_(std::move(inherited)) {}

std::vector<File> SocketStore::inherited() {
  const bool is_for_us = number_in("LISTEN_PID") == ::getpid();
  const int count = is_for_us ? std::clamp(number_in("LISTEN_FDS"), 0, kInheritedMax) : 0;
  for (const char* name : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"})
    ::unsetenv(name);  // NOLINT(concurrency-mt-unsafe)
  std::vector<File> sockets;
  for (int number = kFirstInherited; number < kFirstInherited + count; ++number) {
    File file(number);
    ::fcntl(number, F_SETFD, FD_CLOEXEC);
    ::fcntl(number, F_SETFL, ::fcntl(number, F_GETFL) | O_NONBLOCK);
    if (OwnAddress(number).size > 0) sockets.push_back(std::move(file));
  }
  return sockets;
}

File SocketStore::take(int type, const sockaddr& address) {
  const auto found = std::ranges::find_if(inherited_, [&](const File& file) {
    return type_of(file.get()) == type &&
           same_address(OwnAddress(file.get()).as<sockaddr>(), address);
  });
  if (found == inherited_.end()) return {};
  File taken = std::move(*found);
  inherited_.erase(found);
  return taken;
}

// Nobody finds a socket whose file was removed.
File SocketStore::take_unix(const std::string& path) {
  sockaddr_un address{};
  if (path.size() >= sizeof address.sun_path || file_at(path).inode == 0) return {};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  return take(SOCK_SEQPACKET, reinterpret_cast<const sockaddr&>(address));
}

bool SocketStore::keep(int socket) { return manager_.keep(name_of(socket), socket); }

std::vector<std::string> SocketStore::forget_rest() {
  std::vector<std::string> names;
  for (const File& file : std::exchange(inherited_, {})) {
    names.push_back(name_of(file.get()));
    manager_.forget(names.back());
  }
  return names;
}

}  // namespace tims::os
