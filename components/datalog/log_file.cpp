#include "components/datalog/log_file.h"

#include <fcntl.h>
#include <unistd.h>

namespace rack::datalog {

tims::Result<void> LogFile::create(const std::string& path) {
  path_ = path;
  size_ = 0;
  file_ = tims::os::File(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file_) return tims::os::system_error(path);
  return {};
}

tims::Result<void> LogFile::append(std::string_view text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t size = ::pwrite(file_.get(), text.data() + written, text.size() - written,
                                  size_ + static_cast<off_t>(written));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      const tims::Error error = tims::os::system_error(path_);
      // Half a line would spoil the next one.
      if (written > 0 && ::ftruncate(file_.get(), size_) != 0) return tims::os::system_error(path_);
      return error;
    }
    written += static_cast<std::size_t>(size);
  }
  size_ += static_cast<off_t>(written);
  return {};
}

}  // namespace rack::datalog
