#include "router/io/http/console_folder.h"

#include <array>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/file.h"

namespace tims::io {
namespace {

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;
constexpr int kDepthMax = 4;
// Of everything in a folder, so that one without files ends, too: each file has three forms.
constexpr int kEntriesMax = 4 * static_cast<int>(ConsoleFiles::kFilesMax);

class FolderReader {
 public:
  explicit FolderReader(std::string root) : root_(std::move(root)) {}

  Result<ConsoleFiles> read() {
    os::File folder(::open(root_.c_str(), kFolderFlags));
    if (!folder) return os::system_error(root_);
    if (const auto done = read_folder(std::move(folder), "", 0); !done) return done.error();
    if (const auto checked = files_.check(); !checked) return located(checked.error());
    return std::move(files_);
  }

 private:
  // `path`: relative to the root, with a slash at its end; empty for the root.
  Result<void> read_folder(os::File folder, const std::string& path, int depth) {
    if (depth == kDepthMax) return refused(path, "folders are nested too deeply");
    const std::unique_ptr<DIR, int (*)(DIR*)> listing(::fdopendir(folder.get()), ::closedir);
    if (!listing) return os::system_error(root_ + '/' + path);
    const int fd = folder.release();  // closed with the listing
    while (const dirent* entry = ::readdir(listing.get())) {
      const std::string_view name = entry->d_name;
      if (name == "." || name == "..") continue;
      if (++entries_ > kEntriesMax) return refused(path, "there are too many files in this folder");
      if (const auto done = read_entry(fd, path, std::string(name), depth); !done) return done;
    }
    return {};
  }

  Result<void> read_entry(int folder, const std::string& path, const std::string& name, int depth) {
    const std::string whole = path + name;
    struct ::stat status {};
    if (::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
      return os::system_error(root_ + '/' + whole);
    if (S_ISDIR(status.st_mode)) {
      os::File below(::openat(folder, name.c_str(), kFolderFlags | O_NOFOLLOW));
      if (!below) return os::system_error(root_ + '/' + whole);
      return read_folder(std::move(below), whole + '/', depth + 1);
    }
    if (!S_ISREG(status.st_mode))
      return refused(whole, S_ISLNK(status.st_mode) ? "it is a link: copy the file instead"
                                                    : "it is neither a file nor a folder");
    auto bytes = read_bytes(folder, name);
    if (!bytes)
      return Error(bytes.error().code(),
                   fmt::format("{}/{}: {}", root_, whole, bytes.error().detail()));
    const auto added = files_.add(whole, std::move(*bytes));
    return added ? Result<void>() : located(added.error());
  }

  // At most one byte more than the console may have: then it is refused. Another file may have
  // taken the name by now: it is opened without waiting, and looked at again.
  Result<std::string> read_bytes(int folder, const std::string& name) const {
    const os::File file(
        ::openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    struct ::stat status {};
    if (!file || ::fstat(file.get(), &status) != 0) return os::system_error("cannot be read");
    if (!S_ISREG(status.st_mode)) return Error(Errc::kInvalidArgument, "it is not a file");
    std::string bytes;
    std::array<char, 64 << 10> part{};
    while (bytes.size() <= ConsoleFiles::kBytesMax) {
      const ssize_t n = ::read(file.get(), part.data(), part.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return os::system_error("cannot be read");
      if (n == 0) break;
      bytes.append(part.data(), static_cast<std::size_t>(n));
    }
    return bytes;
  }

  [[nodiscard]] Error refused(const std::string& path, std::string_view why) const {
    return {Errc::kInvalidArgument, fmt::format("{}/{}: {}", root_, path, why)};
  }
  [[nodiscard]] Error located(const Error& error) const {
    return {error.code(), fmt::format("{}: {}", root_, error.detail())};
  }

  const std::string root_;
  ConsoleFiles files_;
  int entries_ = 0;
};

}  // namespace

std::string default_console_folder() {
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  return (program.parent_path().parent_path() / "share/tims/console").string();
}

Result<ConsoleFiles> read_console(const std::string& folder) { return FolderReader(folder).read(); }

}  // namespace tims::io
