#include "os/socket_store.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/stat.h>
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

bool is_memory(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

// Takes the first name off a list with colons between them.
std::string take_name(std::string_view& names) {
  const std::size_t end = std::min(names.find(':'), names.size());
  const std::string name(names.substr(0, end));
  names.remove_prefix(std::min(end + 1, names.size()));
  return name;
}

}  // namespace

SocketStore::SocketStore(ServiceManager& manager, Inherited inherited)
    : manager_(manager), inherited_(std::move(inherited)) {}

SocketStore::Inherited SocketStore::inherited() {
  const std::string all_names = environment("LISTEN_FDNAMES");
  std::string_view names = all_names;
  const bool is_for_us = number_in("LISTEN_PID") == ::getpid();
  const int count = is_for_us ? std::clamp(number_in("LISTEN_FDS"), 0, kInheritedMax) : 0;
  for (const char* name : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"})
    ::unsetenv(name);  // NOLINT(concurrency-mt-unsafe)
  Inherited inherited;
  for (int number = kFirstInherited; number < kFirstInherited + count; ++number) {
    File file(number);
    const std::string name = take_name(names);
    ::fcntl(number, F_SETFD, FD_CLOEXEC);
    if (is_memory(number)) {
      inherited.memory.insert_or_assign(name, std::move(file));
      continue;
    }
    ::fcntl(number, F_SETFL, ::fcntl(number, F_GETFL) | O_NONBLOCK);
    if (!name_of(number).empty()) inherited.sockets.push_back(std::move(file));
  }
  return inherited;
}

File SocketStore::take(int type, const sockaddr& address) {
  const std::string wanted = name_of(type, address);
  const auto is_wanted = [&](const File& file) {
    return type_of(file.get()) == type && name_of(file.get()) == wanted;
  };
  std::vector<File>& sockets = inherited_.sockets;
  const auto found = std::ranges::find_if(sockets, is_wanted);
  if (found == sockets.end()) return {};
  File taken = std::move(*found);
  sockets.erase(found);
  // What a unit for sockets has opened comes before what is stored: the same, or what it replaces.
  if (std::erase_if(sockets, is_wanted) > 0) manager_.forget(without_colons(wanted));
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

File SocketStore::take_memory(const std::string& name) {
  const auto found = inherited_.memory.find(name);
  if (found == inherited_.memory.end() || !manager_.forget(name)) return {};
  File taken = std::move(found->second);
  inherited_.memory.erase(found);
  return taken;
}

bool SocketStore::keep_memory(const std::string& name, int memfd) {
  return manager_.keep(name, memfd);
}

std::vector<std::string> SocketStore::forget_rest() {
  std::vector<std::string> names;
  const Inherited rest = std::exchange(inherited_, {});
  for (const File& file : rest.sockets) names.push_back(without_colons(name_of(file.get())));
  for (const auto& [name, file] : rest.memory) names.push_back(name);
  for (const std::string& name : names) manager_.forget(name);
  return names;
}

}  // namespace tims::os
