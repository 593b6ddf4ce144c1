#include "os/replace_file.h"

#include <sys/stat.h>

#include "os/file.h"

namespace tims::os {
namespace {

Result<void> write_all(const File& file, std::string_view text, const std::string& path) {
  while (!text.empty()) {
    const ssize_t size = ::write(file.get(), text.data(), text.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return system_error(path);
    text.remove_prefix(static_cast<std::size_t>(size));
  }
  return {};
}

Result<void> sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder =
      slash == std::string::npos ? "." : path.substr(0, std::max<std::size_t>(slash, 1));
  const File opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened || ::fsync(opened.get()) != 0) return system_error(folder);
  return {};
}

Result<void> keep_owner_and_mode(const File& made, const struct stat& old,
                                 const std::string& path) {
  if (::fchown(made.get(), old.st_uid, old.st_gid) != 0 && errno != EPERM)
    return system_error(path);
  if (::fchmod(made.get(), old.st_mode & 07777) != 0) return system_error(path);
  return {};
}

Result<void> fill(const File& file, const std::string& path, std::string_view text,
                  const struct stat* old) {
  if (auto done = write_all(file, text, path); !done) return done;
  if (old != nullptr)
    if (auto done = keep_owner_and_mode(file, *old, path); !done) return done;
  if (::fsync(file.get()) != 0) return system_error(path);
  return {};
}

}  // namespace

Result<void> replace_file(const std::string& path, std::string_view text, mode_t mode) {
  struct stat old {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) return system_error(path);
  const std::string made = path + ".new";
  ::unlink(made.c_str());  // left by an interrupted attempt
  const File file(::open(made.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                         exists ? 0600 : mode));
  if (!file) return system_error(made);
  Result<void> done = fill(file, made, text, exists ? &old : nullptr);
  if (done && ::rename(made.c_str(), path.c_str()) != 0) done = system_error(path);
  if (!done) {
    ::unlink(made.c_str());
    return done;
  }
  return sync_folder_of(path);
}

Result<void> remove_file(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return system_error(path);
  return sync_folder_of(path);
}

}  // namespace tims::os
