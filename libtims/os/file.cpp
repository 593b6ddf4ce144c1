#include "os/file.h"

#include <sys/stat.h>
#include <sys/sysmacros.h>

namespace tims::os {
namespace {

// A device other than a terminal and /dev/null: /dev/zero would fill the memory up to the limit,
// and a disk is not the file that somebody wants to read.
bool is_endless(int file, const struct stat& status) {
  const dev_t null = makedev(1, 3);
  if (S_ISBLK(status.st_mode)) return true;
  return S_ISCHR(status.st_mode) && status.st_rdev != null && ::isatty(file) == 0;
}

Error too_big(const std::string& path, std::size_t bytes_max) {
  constexpr std::size_t kMiB = 1 << 20;
  return {Errc::kTooBig, path + ": larger than " +
                             (bytes_max < kMiB ? std::to_string(bytes_max) + " bytes"
                                               : std::to_string(bytes_max / kMiB) + " MB")};
}

}  // namespace

Result<std::string> read_file(const std::string& path, std::size_t bytes_max) {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return system_error(path);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return system_error(path);
  if (is_endless(file.get(), status))
    return Error(Errc::kInvalidArgument, path + ": is a device, not a file");
  if (S_ISREG(status.st_mode) && static_cast<std::size_t>(status.st_size) > bytes_max)
    return too_big(path, bytes_max);
  std::string content;
  std::array<char, 64 << 10> piece{};
  while (const ssize_t size = ::read(file.get(), piece.data(), piece.size())) {
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return system_error(path);
    content.append(piece.data(), static_cast<std::size_t>(size));
    if (content.size() > bytes_max) return too_big(path, bytes_max);
  }
  return content;
}

}  // namespace tims::os
