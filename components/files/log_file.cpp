#include "components/files/log_file.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "components/files/new_file.h"

namespace rack {
namespace {

constexpr off_t kBlock = 4096;

}  // namespace

tims::Error LogFile::error() const { return file_error(path_); }

void LogFile::begin(tims::os::File file, std::string path) {
  path_ = std::move(path);
  size_ = 0;
  file_ = std::move(file);
}

tims::Result<std::uint64_t> LogFile::open(const std::string& path) {
  path_ = path;
  file_ = tims::os::File(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (!file_) return error();
  off_t there = ::lseek(file_.get(), 0, SEEK_END);
  if (there < 0 && errno != ESPIPE) return error();
  there = std::max<off_t>(there, 0);
  const auto end = end_of_lines(there);
  if (!end) return end.error();
  size_ = *end;
  if (size_ < there && ::ftruncate(file_.get(), size_) != 0) return error();
  return static_cast<std::uint64_t>(there - size_);
}

// The position after the last line end.
tims::Result<off_t> LogFile::end_of_lines(off_t size) const {
  std::array<char, kBlock> block{};
  while (size > 0) {
    const off_t from = (size - 1) / kBlock * kBlock;
    const ssize_t got =
        ::pread(file_.get(), block.data(), static_cast<std::size_t>(size - from), from);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error();
    const std::string_view text(block.data(), static_cast<std::size_t>(got));
    const std::size_t line_end = text.rfind('\n');
    if (line_end != std::string_view::npos) return from + static_cast<off_t>(line_end) + 1;
    size = from;
  }
  return size;
}

tims::Result<void> LogFile::append(std::string_view text) {
  std::size_t written = 0;
  while (written < text.size()) {
    const ssize_t size = ::write(file_.get(), text.data() + written, text.size() - written);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      const tims::Error why = error();
      // An incomplete line would corrupt the next one.
      if (written > 0 && ::ftruncate(file_.get(), size_) != 0) return error();
      return why;
    }
    written += static_cast<std::size_t>(size);
  }
  size_ += static_cast<off_t>(written);
  return {};
}

tims::Result<void> LogFile::sync() {
  // EINVAL: the file is a pipe or a device.
  if (::fdatasync(file_.get()) != 0 && errno != EINVAL) return error();
  return {};
}

tims::Result<void> sync_folder(const std::string& path) {
  const tims::os::File folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || ::fsync(folder.get()) != 0) return file_error(path);
  return {};
}

}  // namespace rack
