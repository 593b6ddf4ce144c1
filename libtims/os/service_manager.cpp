#include "os/service_manager.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/un.h>

#include "os/clock.h"
#include "os/environment.h"

namespace tims::os {

namespace {

constexpr Duration kKeepPatience = std::chrono::milliseconds(500);

// For a manager that is busy: tries again until it has room.
template <typename Try>
bool succeeds_within(Duration patience, Try attempt) {
  constexpr timespec kMoment{0, 1'000'000};
  const Time end = deadline_after(patience);
  bool done = attempt();
  for (; !done && now() < end; done = attempt()) ::nanosleep(&kMoment, nullptr);
  return done;
}

// The connection that this program has inherited; empty: none.
File inherited_connection() {
  const std::string text = environment(ServiceManager::kConnectionVariable);
  ::unsetenv(ServiceManager::kConnectionVariable);  // NOLINT(concurrency-mt-unsafe)
  int descriptor = -1;
  if (std::from_chars(text.data(), text.data() + text.size(), descriptor).ec != std::errc())
    return {};
  if (descriptor < 0 || ServiceManager::connection_text(descriptor) != text) return {};
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  return File(descriptor);
}

}  // namespace

ServiceManager::ServiceManager(std::string path) : path_(std::move(path)) {
  if (path_.size() >= sizeof sockaddr_un::sun_path) path_.clear();
  if (!path_.empty()) socket_ = File(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

ServiceManager::ServiceManager(File connection) : socket_(std::move(connection)) {}

ServiceManager ServiceManager::of_environment() {
  if (File connection = inherited_connection()) return ServiceManager(std::move(connection));
  return ServiceManager(environment("NOTIFY_SOCKET"));
}

std::string ServiceManager::connection_text(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISSOCK(status.st_mode)) return {};
  return std::to_string(descriptor) + ":" + std::to_string(status.st_ino);
}

bool ServiceManager::report(std::string_view variable, std::string_view value) {
  if (!socket_) return true;
  const std::lock_guard lock(mutex_);
  kept_.insert_or_assign(std::string(variable), std::string(value));
  return flush_locked();
}

bool ServiceManager::report(std::string_view variable, std::string_view value, Duration patience) {
  return report(variable, value) || succeeds_within(patience, [this] { return flush(); });
}

// FDPOLL=0: an error of a socket is the program's affair.
bool ServiceManager::keep(std::string_view name, int socket) {
  return send_about_sockets("FDSTORE=1\nFDPOLL=0\nFDNAME=" + std::string(name), socket);
}

bool ServiceManager::forget(std::string_view name) {
  return send_about_sockets("FDSTOREREMOVE=1\nFDNAME=" + std::string(name), -1);
}

bool ServiceManager::send_about_sockets(const std::string& text, int socket) const {
  if (!socket_ || path_.empty()) return false;  // `timsctl up` keeps none
  return succeeds_within(kKeepPatience, [&] { return send(text, socket); });
}

bool ServiceManager::flush() {
  const std::lock_guard lock(mutex_);
  return flush_locked();
}

bool ServiceManager::flush_locked() {
  while (!kept_.empty()) {
    const auto& [variable, value] = *kept_.begin();
    if (!send(std::string(variable).append("=").append(value))) return false;
    kept_.erase(kept_.begin());
  }
  return true;
}

// False: there is no room now. A manager that has gone or refuses the report is not asked again.
bool ServiceManager::send(const std::string& text, int socket) const {
  sockaddr_un address{};
  socklen_t size = 0;
  if (!path_.empty()) {
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path_.data(), path_.size());
    if (path_[0] == '@') address.sun_path[0] = '\0';
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  }
  iovec part{const_cast<char*>(text.data()), text.size()};
  msghdr message{};
  if (size > 0) message.msg_name = &address;
  message.msg_namelen = size;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof socket)> control{};
  if (socket >= 0) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof socket);
    std::memcpy(CMSG_DATA(header), &socket, sizeof socket);
  }
  return ::sendmsg(socket_.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT) >= 0 ||
         (errno != EAGAIN && errno != ENOBUFS);
}

}  // namespace tims::os
