#include "components/files/new_file.h"

#include <atomic>
#include <cstdio>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace rack {
namespace {

constexpr int kTries = 100;  // names left by programs that crashed
constexpr mode_t kNewMode = 0644;
constexpr mode_t kModeBits = 07777;

std::string name_beside() {
  static std::atomic<unsigned> last = 0;
  return ".new-" + std::to_string(::getpid()) + "-" + std::to_string(++last);
}

}  // namespace

tims::Error file_error(const std::string& path) {
  const bool full = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
  const tims::Error error = tims::os::system_error(path);
  return full ? tims::Error(tims::Errc::kDiskFull, error.detail()) : error;
}

NewFile::NewFile(int folder, std::string name, std::string shown)
    : folder_(folder), name_(std::move(name)), shown_(std::move(shown)) {}

NewFile::NewFile(NewFile&& other) noexcept
    : folder_(other.folder_),
      name_(std::move(other.name_)),
      shown_(std::move(other.shown_)),
      beside_(std::exchange(other.beside_, {})),
      file_(std::move(other.file_)) {}

NewFile::~NewFile() {
  if (!beside_.empty()) ::unlinkat(folder_, beside_.c_str(), 0);
}

tims::Result<NewFile> NewFile::create(int folder, const std::string& name, std::string shown,
                                      bool links) {
  struct stat old {};
  const bool replaces = ::fstatat(folder, name.c_str(), &old, AT_SYMLINK_NOFOLLOW) == 0;
  if (!replaces && errno != ENOENT) return tims::os::system_error(shown);
  const bool is_link = replaces && S_ISLNK(old.st_mode);
  if (is_link && !links)
    return tims::Error(tims::Errc::kInvalidArgument, shown + ": is a link; use another name");
  if (replaces && !is_link && !S_ISREG(old.st_mode))
    return tims::Error(tims::Errc::kInvalidArgument,
                       shown + (S_ISDIR(old.st_mode) ? ": is a folder" : ": is not a file") +
                           "; use another name");
  NewFile made(folder, name, std::move(shown));
  const bool keeps_mode = replaces && !is_link;
  if (auto opened = made.open(keeps_mode ? 0600 : kNewMode); !opened) return opened.error();
  if (keeps_mode) {
    // The owner can be kept by root only. It comes first, because a new owner resets mode bits.
    (void)::fchown(made.get(), old.st_uid, old.st_gid);
    if (::fchmod(made.get(), old.st_mode & kModeBits) != 0) return made.error();
  }
  return made;
}

tims::Result<void> NewFile::open(mode_t mode) {
  for (int i = 0; i < kTries && !file_; ++i) {
    beside_ = name_beside();
    file_ = tims::os::File(::openat(folder_, beside_.c_str(),
                                    O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                                    mode));
    if (!file_ && errno != EEXIST) break;
  }
  if (file_) return {};
  beside_.clear();
  return error();
}

tims::Result<void> NewFile::write(std::string_view contents) {
  while (!contents.empty()) {
    const ssize_t size = ::write(file_.get(), contents.data(), contents.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return error();
    contents.remove_prefix(static_cast<std::size_t>(size));
  }
  return {};
}

tims::Result<void> NewFile::sync() {
  if (::fsync(file_.get()) != 0 && errno != EINVAL) return error();
  return {};
}

tims::Result<void> NewFile::rename() {
  if (::renameat(folder_, beside_.c_str(), folder_, name_.c_str()) != 0) return error();
  beside_.clear();
  return {};
}

}  // namespace rack
