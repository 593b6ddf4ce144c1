#include "tools/configuration/folder.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include "os/file.h"
#include "os/replace_file.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;
using tims::os::File;

constexpr std::string_view kRouterFile = "router.toml";
constexpr std::array<std::string_view, 2> kFolders{"robots/", "router.d/"};
constexpr std::string_view kEnding = ".toml";
constexpr std::size_t kNameMax = 31;

bool is_plain_name(std::string_view name) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  return !name.empty() && name.size() <= kNameMax && name.front() != '-' &&
         std::ranges::all_of(name, fits);
}

bool is_true_folder(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

// Empty optional: there is no such file, or it is none of ours.
tims::Result<std::string> read_plain(const std::string& path) {
  const File file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) return tims::os::system_error(path);
  if (!S_ISREG(status.st_mode))
    return tims::Error(tims::Errc::kInvalidArgument, path + ": is not a plain file");
  return tims::os::read_file(fmt::format("/proc/self/fd/{}", file.get()), kFileMax);
}

}  // namespace

bool is_file_name(std::string_view name) {
  if (name == kRouterFile) return true;
  if (!name.ends_with(kEnding)) return false;
  for (const std::string_view folder : kFolders)
    if (name.starts_with(folder))
      return is_plain_name(
          name.substr(folder.size(), name.size() - folder.size() - kEnding.size()));
  return false;
}

bool is_robot_file(std::string_view name) { return name.starts_with(kFolders[0]); }

std::string hash_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return fmt::format("{:016x}", hash);
}

tims::Result<Texts> Folder::read() const {
  Texts all;
  const auto add = [&](const std::string& name) -> tims::Result<void> {
    struct stat status {};
    if (!is_file_name(name) || ::lstat(path_of(name).c_str(), &status) != 0 ||
        !S_ISREG(status.st_mode))
      return {};
    auto text = read_plain(path_of(name));
    if (!text)
      return tims::Error(text.error().code(), path_of(name) + ": " + text.error().detail());
    all.emplace(name, std::move(*text));
    if (all.size() > kFilesMax)
      return tims::Error(tims::Errc::kTooBig,
                         fmt::format("{}: more than {} files", path_, kFilesMax));
    return {};
  };
  if (auto done = add(std::string(kRouterFile)); !done) return done.error();
  for (const std::string_view folder : kFolders) {
    const std::string where = path_of(folder.substr(0, folder.size() - 1));
    std::error_code error;
    if (!is_true_folder(where)) continue;
    for (const auto& entry : fs::directory_iterator(where, error))
      if (auto done = add(std::string(folder) + entry.path().filename().string()); !done)
        return done.error();
    if (error) return tims::Error(tims::Errc::kSystem, where + ": " + error.message());
  }
  return all;
}

tims::Result<void> Folder::write(const Texts& wanted) const {
  const auto now = read();
  if (!now) return now.error();
  for (const auto& [name, text] : wanted) {
    const auto old = now->find(name);
    if (!is_file_name(name) || (old != now->end() && old->second == text)) continue;
    struct stat status {};
    if (::lstat(path_of(name).c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      return tims::Error(tims::Errc::kInvalidArgument, path_of(name) + ": is not a plain file");
    if (const std::size_t slash = name.find('/'); slash != std::string::npos)
      ::mkdir(path_of(name.substr(0, slash)).c_str(), 0755);
    if (auto done = tims::os::replace_file(path_of(name), text); !done) return done;
  }
  for (const auto& [name, text] : *now)
    if (!wanted.contains(name))
      if (auto done = tims::os::remove_file(path_of(name)); !done) return done;
  return {};
}

}  // namespace timsctl::configuration
