#include "os/socket.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>

#include <linux/tcp.h>  // newer than <netinet/tcp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "os/wakeup.h"

namespace tims::os {

namespace {

std::optional<sockaddr_un> socket_address(const std::string& path) {
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof address.sun_path) return std::nullopt;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

Error bad_path(const std::string& path) {
  return {Errc::kInvalidArgument, "'" + path + "' is not a socket path of 1 to 107 bytes"};
}

// Refuses a path below a directory that another user created in a world-writable directory. Root
// and the user that runs this program are trusted.
Result<void> check_owners(const std::filesystem::path& path) {
  for (auto folder = path.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    struct stat self {};
    struct stat parent {};
    if (::lstat(folder.c_str(), &self) != 0 || ::stat(folder.parent_path().c_str(), &parent) != 0)
      continue;
    const bool for_everybody = (parent.st_mode & S_ISVTX) != 0 && (parent.st_mode & S_IWOTH) != 0;
    if (for_everybody && self.st_uid != 0 && self.st_uid != ::geteuid())
      return Error(Errc::kSystem, folder.string() + " belongs to another user (" +
                                      std::to_string(self.st_uid) +
                                      "), who could replace the socket: choose another directory");
  }
  return {};
}

File make_socket(int flags) {
  return File(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | flags, 0));
}

// Control data for at most kRecordFilesMax descriptors.
struct alignas(cmsghdr) Control {
  std::array<char, CMSG_SPACE(kRecordFilesMax * sizeof(int))> bytes;
};

std::vector<File> take_files(msghdr& message) {
  std::vector<File> files;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(c) + i * sizeof(int), sizeof fd);
      files.emplace_back(fd);
    }
  }
  return files;
}

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Result<AddressList> look_up(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
  if (error != 0) return Error(Errc::kSystem, ::gai_strerror(error));
  return AddressList(found, ::freeaddrinfo);
}

// Returns 0, or the errno of the failure.
int wait_connected(int socket, Time deadline, int cancel) {
  std::array<pollfd, 2> waits{{{socket, POLLOUT, 0}, {cancel, POLLIN, 0}}};
  (void)poll_until(waits, deadline);
  if (waits[1].revents != 0) return ECANCELED;
  if (waits[0].revents == 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

int try_connect(int socket, const addrinfo& address, Time deadline, int cancel) {
  if (::connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  return errno == EINPROGRESS ? wait_connected(socket, deadline, cancel) : errno;
}

// Detects also a router that does not respond for this time while messages wait for it.
void find_dead_router(int socket) {
  constexpr int kUnansweredMs = 20'000;
  keep_alive(socket, {.idle_s = 10, .probe_s = 2, .probes = 3});
  set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kUnansweredMs);
}

}  // namespace

void set_option(int socket, int level, int option, int value) {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

void keep_alive(int socket, const KeepAlive& settings) {
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, settings.idle_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, settings.probe_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, settings.probes);
}

// --- Unix sockets

Result<File> connect_unix(const std::string& path) {
  const auto address = socket_address(path);
  if (!address) return bad_path(path);
  File socket = make_socket(0);
  if (!socket) return system_error("socket");
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return system_error("connect " + path);
  return socket;
}

Result<RecordPair> make_record_pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return system_error("socketpair");
  return RecordPair{File(ends[0]), File(ends[1])};
}

Result<File> listen_unix(const std::string& path, mode_t mode) {
  const auto address = socket_address(path);
  if (!address) return bad_path(path);
  if (connect_unix(path).ok())
    return Error(Errc::kAddressInUse, "another router listens at " + path);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure)
    return Error(Errc::kSystem, "cannot make " + folder.string() + ": " + failure.message());
  if (auto safe = check_owners(std::filesystem::absolute(path)); !safe) return safe.error();
  ::unlink(path.c_str());
  File socket = make_socket(SOCK_NONBLOCK);
  if (!socket) return system_error("socket");
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return system_error("bind " + path);
  if (::chmod(path.c_str(), mode) != 0) return system_error("chmod " + path);
  if (::listen(socket.get(), SOMAXCONN) != 0) return system_error("listen " + path);
  return socket;
}

FileId file_at(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

Result<File> accept_unix(const File& listener) {
  File socket(::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (socket) return socket;
  if (errno == EAGAIN || errno == EINTR || errno == ECONNABORTED) return Errc::kEmpty;
  return system_error("accept");
}

Result<void> send_record(int socket, std::span<const std::byte> record, std::span<const int> files,
                         bool wait) {
  iovec part{const_cast<std::byte*>(record.data()), record.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  Control control{};
  if (files.size() > kRecordFilesMax) return Errc::kInvalidArgument;
  if (!files.empty()) {
    message.msg_control = control.bytes.data();
    message.msg_controllen = CMSG_SPACE(files.size_bytes());
    cmsghdr* c = CMSG_FIRSTHDR(&message);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_RIGHTS;
    c->cmsg_len = CMSG_LEN(files.size_bytes());
    std::memcpy(CMSG_DATA(c), files.data(), files.size_bytes());
  }
  for (;;) {
    if (::sendmsg(socket, &message, MSG_NOSIGNAL | (wait ? 0 : MSG_DONTWAIT)) >= 0) return {};
    if (errno == EINTR) continue;
    if (errno == EAGAIN) return Errc::kEmpty;
    if (errno == EPIPE || errno == ECONNRESET || errno == ENOTCONN) return Errc::kClosed;
    return system_error("sendmsg");
  }
}

Result<Received> receive_record(int socket, std::span<std::byte> buffer, bool wait) {
  iovec part{buffer.data(), buffer.size()};
  Control control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  for (;;) {
    const ssize_t n = ::recvmsg(socket, &message, MSG_CMSG_CLOEXEC | (wait ? 0 : MSG_DONTWAIT));
    if (n >= 0) {
      return Received{.size = static_cast<std::size_t>(n),
                      .truncated = (message.msg_flags & MSG_TRUNC) != 0,
                      .files_lost = (message.msg_flags & MSG_CTRUNC) != 0,
                      .files = take_files(message)};
    }
    if (errno == EINTR) continue;
    if (errno == EAGAIN) return Errc::kEmpty;
    if (errno == ECONNRESET || errno == ENOTCONN) return Received{};
    return system_error("recvmsg");
  }
}

PeerCredentials peer_credentials(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return {};
  return {credentials.pid, credentials.uid};
}

bool has_hung_up(int socket) {
  pollfd look{socket, 0, 0};
  return ::poll(&look, 1, 0) == 1 && (look.revents & POLLHUP) != 0;
}

// --- TCP

Result<File> connect_tcp(const std::string& host, std::uint16_t port, Time deadline, int cancel) {
  const auto addresses = look_up(host, port);
  if (!addresses) return addresses.error();
  for (const addrinfo* a = addresses->get(); a != nullptr; a = a->ai_next) {
    File socket(::socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    errno = socket ? try_connect(socket.get(), *a, deadline, cancel) : errno;
    if (errno != 0) continue;
    set_option(socket.get(), IPPROTO_TCP, TCP_NODELAY, 1);
    find_dead_router(socket.get());
    return socket;
  }
  return Error(Errc::kSystem, std::generic_category().message(errno));
}

Bound bind_even_early(int socket, const sockaddr* address, socklen_t size) {
  if (::bind(socket, address, size) == 0) return Bound::kYes;
  if (errno != EADDRNOTAVAIL) return Bound::kNo;
  const bool v6 = address->sa_family == AF_INET6;
  v6 ? set_option(socket, IPPROTO_IPV6, IPV6_FREEBIND, 1)
     : set_option(socket, IPPROTO_IP, IP_FREEBIND, 1);
  return ::bind(socket, address, size) == 0 ? Bound::kAddressNotHereYet : Bound::kNo;
}

std::uint64_t bytes_acknowledged(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  ::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size);
  return info.tcpi_bytes_acked;
}

}  // namespace tims::os
