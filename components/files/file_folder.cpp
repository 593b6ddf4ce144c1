#include "components/files/file_folder.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>

#include "components/files/new_file.h"
#include "components/files/whole_file.h"
#include "os/environment.h"

namespace rack {
namespace {

constexpr std::size_t kPlainNameMax = 200;

// Control characters in a name from the network would garble logs and terminals.
std::string printable(std::string_view name) {
  std::string text(name.substr(0, kPlainNameMax));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' ' || c == 0x7F; }, '?');
  return text;
}

tims::Error not_plain(std::string_view name, const std::string& folder) {
  return {tims::Errc::kInvalidArgument, "\"" + printable(name) +
                                            "\": a message can name only a file in " + folder +
                                            ", without a path; not a hidden one"};
}

}  // namespace

bool is_plain_name(std::string_view name) {
  const auto is_bad = [](unsigned char c) { return c < ' ' || c == 0x7F || c == '/'; };
  return !name.empty() && name.size() <= kPlainNameMax && name.front() != '.' &&
         std::ranges::none_of(name, is_bad);
}

tims::Result<FileFolder> FileFolder::of_messages() {
  using tims::os::environment;
  if (const std::string given = environment("RACK_FILES"); !given.empty()) return FileFolder(given);
  if (const std::string data = environment("XDG_DATA_HOME"); !data.empty())
    return FileFolder(data + "/rack");
  if (const std::string home = environment("HOME"); !home.empty())
    return FileFolder(home + "/.local/share/rack");
  return tims::Error(tims::Errc::kInvalidArgument,
                     "there is no folder for files that messages name; give it by \"files\" in the "
                     "robot file, or by RACK_FILES in the environment");
}

std::string FileFolder::path_of(std::string_view name) const {
  return std::filesystem::path(path_) / name;
}

tims::Result<std::string> FileFolder::existing(std::string_view name) const {
  if (!is_plain_name(name)) return not_plain(name, path_);
  const std::string path = path_of(name);
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return tims::os::system_error(path);
  if (!S_ISREG(status.st_mode))
    return tims::Error(tims::Errc::kInvalidArgument,
                       path + (S_ISLNK(status.st_mode) ? ": is a link" : ": is not a file"));
  return path;
}

tims::Result<tims::os::File> FileFolder::open(std::string_view name) const {
  if (!is_plain_name(name)) return not_plain(name, path_);
  std::error_code error;
  std::filesystem::create_directories(path_, error);
  tims::os::File folder(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder) return tims::os::system_error(path_);
  return folder;
}

tims::Result<void> FileFolder::write(std::string_view name, std::string_view contents) const {
  const auto folder = open(name);
  if (!folder) return folder.error();
  return write_file_in(folder->get(), std::string(name), path_of(name), contents, false);
}

tims::Result<tims::os::File> FileFolder::create(std::string_view name) const {
  const auto folder = open(name);
  if (!folder) return folder.error();
  auto file = NewFile::create(folder->get(), std::string(name), path_of(name), false);
  if (!file) return file.error();
  if (auto renamed = file->rename(); !renamed) return renamed.error();
  return file->release();
}

tims::Result<std::string> file_to_read(std::string_view name, bool is_foreign) {
  const auto folder = FileFolder::of_messages();
  if (is_foreign && !folder) return folder.error();
  if (folder) {
    auto there = folder->existing(name);
    if (there || is_foreign) return there;
  }
  return std::string(name);
}

}  // namespace rack
