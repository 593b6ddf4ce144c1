#include "os/file.h"

namespace tims::os {

Result<std::string> read_file(const std::string& path, std::size_t bytes_max) {
  constexpr std::size_t kMiB = 1 << 20;
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return system_error(path);
  std::string content;
  std::array<char, 64 << 10> piece{};
  while (const ssize_t size = ::read(file.get(), piece.data(), piece.size())) {
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return system_error(path);
    content.append(piece.data(), static_cast<std::size_t>(size));
    if (content.size() > bytes_max)
      return Error(Errc::kTooBig,
                   path + ": larger than " +
                       (bytes_max < kMiB ? std::to_string(bytes_max) + " bytes"
                                         : std::to_string(bytes_max / kMiB) + " MB"));
  }
  return content;
}

}  // namespace tims::os
