#include "os/environment.h"

#include <cstddef>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>

namespace tims::os {

ServiceManager::ServiceManager(std::string path) : path_(std::move(path)) {
  if (path_.size() >= sizeof sockaddr_un::sun_path) path_.clear();
  if (!path_.empty()) socket_ = File(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

ServiceManager ServiceManager::of_environment() {
  return ServiceManager(environment("NOTIFY_SOCKET"));
}

void ServiceManager::tell(std::string_view text) const {
  if (!socket_) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  if (path_[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  ::sendto(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
           reinterpret_cast<const sockaddr*>(&address), size);
}

}  // namespace tims::os
