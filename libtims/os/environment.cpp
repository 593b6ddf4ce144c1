#include "os/environment.h"

#include <cstddef>
#include <cstring>
#include <filesystem>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace tims::os {

namespace fs = std::filesystem;

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  std::error_code ignored;
  const fs::path own = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* folder : {"", TIMS_BIN_TO_LIBEXEC, TIMS_LIBEXEC_TO_BIN, TIMS_LIBEXEC}) {
    const fs::path path = (own / folder / name).lexically_normal();
    if (::access(path.c_str(), X_OK) == 0) return path;
  }
  return name;
}

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
