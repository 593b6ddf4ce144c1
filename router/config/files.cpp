#include "router/config/files.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace tims::config {
namespace {

namespace fs = std::filesystem;

Error unreadable(const fs::path& path, std::string_view why) {
  return {Errc::kSystem, "cannot read " + path.string() + ": " + std::string(why)};
}

Result<File> read_file(const fs::path& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  File file{.name = path.string(), .text = {}};
  if (stream) file.text.assign(std::istreambuf_iterator<char>(stream), {});
  if (!stream || stream.bad()) return unreadable(path, std::strerror(errno));
  return file;
}

// The *.toml files of a folder, in alphabetical order.
Result<std::vector<fs::path>> toml_files(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> paths;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".toml") paths.push_back(it->path());
  if (error) return unreadable(folder, error.message());
  std::ranges::sort(paths);
  return paths;
}

}  // namespace

Result<std::vector<File>> read_files(const std::filesystem::path& path) {
  std::vector<fs::path> paths;
  fs::path folder = path;
  if (!fs::is_directory(path)) {
    paths.push_back(path);
    folder.replace_extension(".d");
  }
  if (fs::is_directory(folder)) {
    auto more = toml_files(folder);
    if (!more) return more.error();
    paths.insert(paths.end(), more->begin(), more->end());
  }
  std::vector<File> files;
  for (const fs::path& each : paths) {
    auto file = read_file(each);
    if (!file) return file.error();
    files.push_back(std::move(*file));
  }
  return files;
}

}  // namespace tims::config
