#include "os/peer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>

#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

// Since Linux 6.5; not in the headers of Debian 12. Rare architectures have another number, and an
// unknown option is refused as by older kernels.
#ifndef SO_PEERPIDFD
#define SO_PEERPIDFD 77
#endif

namespace tims::os {
namespace {

constexpr std::size_t kProcBytesMax = 64 << 10;
constexpr int kTcpEstablished = 1;  // TCP_ESTABLISHED; <netinet/tcp.h> does not go with others

std::string proc_text(const std::string& proc, pid_t pid, const char* name) {
  auto text = read_file(proc + "/" + std::to_string(pid) + "/" + name, kProcBytesMax);
  return text ? std::move(*text) : std::string();
}

double since_boot_s() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

// Of the process that connected, also if it has ended and others have its number.
File process_at(int socket, bool& is_known) {
  int process = -1;
  socklen_t size = sizeof process;
  is_known =
      ::getsockopt(socket, SOL_SOCKET, SO_PEERPIDFD, &process, &size) == 0 || errno != ENOPROTOOPT;
  return File(process);
}

std::string unit_at(int socket, pid_t pid, const std::string& proc) {
  bool is_known = false;
  if (const File process = process_at(socket, is_known); is_known)
    return process ? unit_of(process, pid, proc) : std::string();
  const double accepted_s = since_boot_s();
  const File process(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (!process || !has_started_by(accepted_s, pid, proc)) return {};
  return unit_of(process, pid, proc);
}

std::vector<gid_t> groups_of(int socket) {
  std::vector<gid_t> groups(64);
  for (;;) {
    auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
    const bool read = ::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) == 0;
    const std::size_t count = size / sizeof(gid_t);
    if (!read && (errno != ERANGE || count <= groups.size())) return {};
    groups.resize(count);
    if (read) return groups;
  }
}

std::string label_of(int socket) {
  std::array<char, 256> text{};
  socklen_t size = text.size();
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERSEC, text.data(), &size) != 0) return {};
  return {text.data(), ::strnlen(text.data(), size)};
}

bool put_address(const sockaddr_storage& address, __be16& port, __be32* bytes) {
  if (address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof v4);
    port = v4.sin_port;
    bytes[0] = v4.sin_addr.s_addr;
    return true;
  }
  if (address.ss_family != AF_INET6) return false;
  sockaddr_in6 v6{};
  std::memcpy(&v6, &address, sizeof v6);
  port = v6.sin6_port;
  std::memcpy(bytes, &v6.sin6_addr, sizeof v6.sin6_addr);
  return true;
}

struct Question {
  nlmsghdr head{};
  inet_diag_req_v2 what{};
};

// Asks for the socket whose own end is the peer's.
std::optional<Question> question_for(int socket) {
  sockaddr_storage here{};
  sockaddr_storage there{};
  socklen_t size = sizeof here;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&here), &size) != 0) return std::nullopt;
  size = sizeof there;
  if (::getpeername(socket, reinterpret_cast<sockaddr*>(&there), &size) != 0) return std::nullopt;
  Question question;
  question.head.nlmsg_len = sizeof question;
  question.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.what.sdiag_family = static_cast<__u8>(there.ss_family);
  question.what.sdiag_protocol = IPPROTO_TCP;
  question.what.idiag_states = 1U << kTcpEstablished;
  inet_diag_sockid& id = question.what.id;
  std::ranges::fill(id.idiag_cookie, INET_DIAG_NOCOOKIE);
  if (!put_address(there, id.idiag_sport, id.idiag_src) ||
      !put_address(here, id.idiag_dport, id.idiag_dst))
    return std::nullopt;
  return question;
}

}  // namespace

// The process keeps its number while the descriptor says that it runs.
std::string unit_of(const File& process, pid_t pid, const std::string& proc) {
  std::string unit = unit_of_cgroup(proc_text(proc, pid, "cgroup"));
  pollfd look{process.get(), POLLIN, 0};
  return ::poll(&look, 1, 0) == 0 ? unit : std::string();
}

// Field 22 of /proc/PID/stat: clock ticks from boot to the start. The second field is a name in
// parentheses, which may contain anything.
bool has_started_by(double since_boot_s, pid_t pid, const std::string& proc) {
  const std::string text = proc_text(proc, pid, "stat");
  std::size_t at = text.rfind(')');
  for (int field = 2; field < 22 && at != std::string::npos; ++field) at = text.find(' ', at + 1);
  if (at == std::string::npos) return false;
  const auto ticks = std::strtoull(text.c_str() + at + 1, nullptr, 10);
  return static_cast<double>(ticks) <= since_boot_s * static_cast<double>(::sysconf(_SC_CLK_TCK));
}

std::optional<LocalPeer> local_peer(int socket, const std::string& proc) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return std::nullopt;
  return LocalPeer{.pid = credentials.pid,
                   .uid = credentials.uid,
                   .gid = credentials.gid,
                   .groups = groups_of(socket),
                   .unit = unit_at(socket, credentials.pid, proc),
                   .label = label_of(socket)};
}

std::optional<uid_t> loopback_peer_uid(int socket) {
  const auto question = question_for(socket);
  if (!question) return std::nullopt;
  const File netlink(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  if (!netlink || ::send(netlink.get(), &*question, sizeof *question, 0) < 0) return std::nullopt;
  alignas(nlmsghdr) std::array<char, 4096> answer{};
  const ssize_t got = ::recv(netlink.get(), answer.data(), answer.size(), MSG_DONTWAIT);
  nlmsghdr head{};
  inet_diag_msg found{};
  if (got < static_cast<ssize_t>(NLMSG_HDRLEN + sizeof found)) return std::nullopt;
  std::memcpy(&head, answer.data(), sizeof head);
  if (head.nlmsg_type != SOCK_DIAG_BY_FAMILY) return std::nullopt;
  std::memcpy(&found, answer.data() + NLMSG_HDRLEN, sizeof found);
  return found.idiag_uid;
}

// The first component that is a unit: those below it are named by whom the unit belongs to, as the
// units of a user's own manager below user@1000.service.
std::string unit_of_cgroup(const std::string& text) {
  const std::size_t line = text.find("0::/");
  if (line == std::string::npos || (line != 0 && text[line - 1] != '\n')) return {};
  std::string path = text.substr(line + 4, text.find('\n', line) - line - 4);
  while (!path.empty()) {
    const std::size_t slash = path.find('/');
    std::string part = path.substr(0, slash);
    if (part.ends_with(".service") || part.ends_with(".scope")) return part;
    path = slash == std::string::npos ? "" : path.substr(slash + 1);
  }
  return {};
}

}  // namespace tims::os
