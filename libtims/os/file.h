// File descriptors with an owner, pipes, whole files, and errno as an Error.
#pragma once

#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "tims/result.h"

namespace tims::os {

class File {
 public:
  File() = default;
  explicit File(int fd) : fd_(fd) {}
  File(File&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  File& operator=(File&& other) noexcept {
    if (this != &other) {
      reset();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  ~File() { reset(); }

  [[nodiscard]] int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  // The descriptor, which the caller closes from now on.
  [[nodiscard]] int release() { return std::exchange(fd_, -1); }
  void reset() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_ = -1;
};

// An error with the system's text for errno after the failed operation.
inline Error system_error(const std::string& what) {
  return {Errc::kSystem, what + ": " + std::generic_category().message(errno)};
}

struct Pipe {
  File read;
  File write;
};

// Both ends are closed in programs that are started.
inline Result<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return system_error("pipe");
  return Pipe{File(ends[0]), File(ends[1])};
}

// The whole content of a file, also of a pipe or in /proc. An error names the file and the reason;
// kTooBig: it has more than `bytes_max`.
Result<std::string> read_file(const std::string& path, std::size_t bytes_max = 512U << 20U);

}  // namespace tims::os
