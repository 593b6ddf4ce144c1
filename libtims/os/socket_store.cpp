#include "os/socket_store.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <utility>

#include <fcntl.h>
#include <netdb.h>
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

int type_of(int socket) {
  int type = 0;
  socklen_t size = sizeof type;
  ::getsockopt(socket, SOL_SOCKET, SO_TYPE, &type, &size);
  return type;
}

// "tcp-127.0.0.1-2000", "unix-/run/tims/router.sock"; empty for another family.
std::string name_of(int type, const sockaddr& address) {
  if (address.sa_family == AF_UNIX)
    return "unix-" + std::string(reinterpret_cast<const sockaddr_un&>(address).sun_path);
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  const socklen_t size = address.sa_family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
  if (::getnameinfo(&address, size, host.data(), host.size(), port.data(), port.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return {};
  return std::string(type == SOCK_DGRAM ? "udp-" : "tcp-") + host.data() + "-" + port.data();
}

std::string name_of(int socket) {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return {};
  return name_of(type_of(socket), reinterpret_cast<const sockaddr&>(bound));
}

// A name at the manager must not contain a colon.
std::string without_colons(std::string name) {
  std::ranges::replace(name, ':', '.');
  return name;
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
    if (!name_of(number).empty()) sockets.push_back(std::move(file));
  }
  return sockets;
}

File SocketStore::take(int type, const sockaddr& address) {
  const std::string wanted = name_of(type, address);
  const auto found = std::ranges::find_if(inherited_, [&](const File& file) {
    return type_of(file.get()) == type && name_of(file.get()) == wanted;
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

bool SocketStore::keep(int socket) {
  return manager_.keep(without_colons(name_of(socket)), socket);
}

std::vector<std::string> SocketStore::forget_rest() {
  std::vector<std::string> names;
  for (const File& file : std::exchange(inherited_, {})) {
    names.push_back(without_colons(name_of(file.get())));
    manager_.forget(names.back());
  }
  return names;
}

}  // namespace tims::os
