#include "tools/timsctl/robot/status_socket.h"

#include <array>
#include <cstring>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "tools/timsctl/failure.h"

namespace timsctl::robot {

namespace {

constexpr std::size_t kTextMax = 1024;

// What stands behind `name` at the beginning of a line.
std::optional<std::string_view> value_of(std::string_view text, std::string_view name) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (line.starts_with(name)) return line.substr(name.size());
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return std::nullopt;
}

}  // namespace

StatusSocket::StatusSocket(std::string path)
    : path_(std::move(path)),
      socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.size() >= sizeof address.sun_path)
    throw Failure(Exit::kDenied, "path", path_ + ": longer than a socket's path may be");
  std::memcpy(address.sun_path, path_.data(), path_.size());
  ::unlink(path_.c_str());  // who listens at the control socket owns the folder
  const int yes = 1;
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::chmod(path_.c_str(), 0600) != 0 ||
      ::setsockopt(socket_.get(), SOL_SOCKET, SO_PASSCRED, &yes, sizeof yes) != 0)
    throw Failure(Exit::kDenied, "system", tims::os::system_error(path_).message());
}

StatusSocket::~StatusSocket() { ::unlink(path_.c_str()); }

std::optional<StatusSocket::Said> StatusSocket::take() {
  std::array<char, kTextMax> text{};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred))> control{};
  iovec whole{text.data(), text.size()};
  msghdr message{};
  message.msg_iov = &whole;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(socket_.get(), &message, 0);
  if (size < 0) return std::nullopt;
  Said said{.text = {text.data(), static_cast<std::size_t>(size)}};
  const cmsghdr* sender = CMSG_FIRSTHDR(&message);
  if (sender != nullptr && sender->cmsg_level == SOL_SOCKET &&
      sender->cmsg_type == SCM_CREDENTIALS) {
    ucred who{};
    std::memcpy(&who, CMSG_DATA(sender), sizeof who);
    said.pid = who.pid;
  }
  return said;
}

std::optional<std::string> status_in(std::string_view text) {
  const auto value = value_of(text, "STATUS=");
  if (!value) return std::nullopt;
  return std::string(*value);
}

std::optional<std::string> address_in(std::string_view text) {
  const auto value = value_of(text, "X_TIMS_ADDRESS=");
  if (!value) return std::nullopt;
  return std::string(*value);
}

std::optional<Told> told_in(std::string_view text, std::string_view what) {
  const auto told = value_of(text, what);
  const std::size_t equals = told ? told->find('=') : std::string_view::npos;
  if (equals == std::string_view::npos) return std::nullopt;
  return Told{std::string(told->substr(0, equals)), std::string(told->substr(equals + 1))};
}

bool says_ready(std::string_view text) { return value_of(text, "READY=") == "1"; }

}  // namespace timsctl::robot
