#include "tools/timsctl/host_facts.h"

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/timex.h>

#include "os/file.h"

namespace timsctl {

namespace fs = std::filesystem;

namespace {

std::string user_name(uid_t id) {
  const passwd* entry = ::getpwuid(id);  // NOLINT(concurrency-mt-unsafe): called from one thread
  return entry == nullptr ? std::to_string(id) : entry->pw_name;
}
std::string group_name(gid_t id) {
  const group* entry = ::getgrgid(id);  // NOLINT(concurrency-mt-unsafe)
  return entry == nullptr ? std::to_string(id) : entry->gr_name;
}

// The socket's inode of a listener at `port`: a row of /proc/net/tcp with state 0A.
std::optional<std::string> listener_inode(const char* table, std::uint16_t port) {
  std::ifstream file(table);
  std::string line;
  std::getline(file, line);
  const std::string wanted = fmt::format(":{:04X}", port);
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::string slot, local, remote, state, skip, inode;
    row >> slot >> local >> remote >> state;
    for (int i = 0; i < 5; ++i) row >> skip;
    row >> inode;
    if (state == "0A" && local.ends_with(wanted)) return inode;
  }
  return std::nullopt;
}

bool has_socket(const fs::path& process, const std::string& inode) {
  std::error_code error;
  for (const auto& fd : fs::directory_iterator(process / "fd", error))
    if (fs::read_symlink(fd.path(), error) == "socket:[" + inode + "]") return true;
  return false;
}

}  // namespace

std::optional<SocketFile> socket_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return SocketFile{status.st_mode & 07777U, user_name(status.st_uid), group_name(status.st_gid)};
}

std::optional<OpenFiles> open_files(std::uint32_t pid) {
  std::ifstream file(fmt::format("/proc/{}/limits", pid));
  std::string line;
  constexpr std::string_view kName = "Max open files";
  while (std::getline(file, line)) {
    if (!line.starts_with(kName)) continue;
    OpenFiles files;
    std::istringstream(line.substr(kName.size())) >> files.limit;
    std::error_code error;
    const fs::directory_iterator all(fmt::format("/proc/{}/fd", pid), error);
    if (!error)
      files.open = static_cast<std::uint64_t>(std::distance(begin(all), fs::directory_iterator()));
    return files;
  }
  return std::nullopt;
}

std::optional<std::string> port_owner(std::uint16_t port) {
  auto inode = listener_inode("/proc/net/tcp", port);
  if (!inode) inode = listener_inode("/proc/net/tcp6", port);
  if (!inode) return std::nullopt;
  std::error_code error;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string pid = process.path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    if (!has_socket(process.path(), *inode)) continue;
    std::string name;
    std::getline(std::ifstream(process.path() / "comm"), name);
    return fmt::format("{} (pid {})", name, pid);
  }
  return "another user's program";
}

SharedMemory shared_memory() {
  SharedMemory memory;
  const tims::os::File file(::memfd_create("timsctl-doctor", MFD_CLOEXEC));
  memory.memfd = static_cast<bool>(file);
  struct statvfs status {};
  if (::statvfs("/dev/shm", &status) == 0)
    memory.free_bytes = std::uint64_t{status.f_bavail} * status.f_frsize;
  return memory;
}

bool clock_is_synchronised() {
  timex query{};
  return ::adjtimex(&query) != TIME_ERROR && (query.status & STA_UNSYNC) == 0;
}

bool is_running(std::uint32_t pid) {
  return ::kill(static_cast<pid_t>(pid), 0) == 0 || errno != ESRCH;
}

std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

}  // namespace timsctl
