#include "os/service_manager.h"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include <sys/socket.h>
#include <sys/un.h>

#include "os/environment.h"

namespace tims::os {

ServiceManager::ServiceManager(std::string path) : path_(std::move(path)) {
  if (path_.size() >= sizeof sockaddr_un::sun_path) path_.clear();
  if (!path_.empty()) socket_ = File(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

ServiceManager ServiceManager::of_environment() {
  return ServiceManager(environment("NOTIFY_SOCKET"));
}

bool ServiceManager::report(std::string_view variable, std::string_view value) {
  if (!socket_) return true;
  const std::lock_guard lock(mutex_);
  kept_.insert_or_assign(std::string(variable), std::string(value));
  return flush_locked();
}

bool ServiceManager::flush() {
  const std::lock_guard lock(mutex_);
  return flush_locked();
}

bool ServiceManager::flush_locked() {
  while (!kept_.empty()) {
    const auto& [variable, value] = *kept_.begin();
    if (!send(variable + "=" + value)) return false;
    kept_.erase(kept_.begin());
  }
  return true;
}

// False: there is no room now. A manager that has gone or refuses the datagram is not asked again.
bool ServiceManager::send(const std::string& text) const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  if (path_[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  return ::sendto(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                  reinterpret_cast<const sockaddr*>(&address), size) >= 0 ||
         (errno != EAGAIN && errno != ENOBUFS);
}

}  // namespace tims::os
