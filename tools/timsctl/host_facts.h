// What this host says about itself: files under /proc, limits, the clock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace timsctl {

struct SocketFile {
  std::uint32_t mode = 0;  // permission bits
  std::string owner;
  std::string group;
};
std::optional<SocketFile> socket_file(const std::string& path);

struct OpenFiles {
  std::uint64_t limit = 0;
  std::optional<std::uint64_t> open;  // nothing when we may not look
};
std::optional<OpenFiles> open_files(std::uint32_t pid);

// Who listens at a TCP port; "another user's program" when it cannot be told.
std::optional<std::string> port_owner(std::uint16_t port);

struct SharedMemory {
  bool memfd = false;            // can be made
  std::uint64_t free_bytes = 0;  // of /dev/shm
};
SharedMemory shared_memory();

bool clock_is_synchronised();
bool is_running(std::uint32_t pid);
// A number under /proc or /sys.
std::optional<std::uint64_t> number_in(const std::string& path);

}  // namespace timsctl
