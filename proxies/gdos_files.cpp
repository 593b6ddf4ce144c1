#include "proxies/gdos_files.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <unistd.h>

#include "os/environment.h"

namespace rack::gdos {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "texts.";
constexpr std::string_view kEnd = ".jsonl";
const fs::path kOfTheHost = "/var/log/tims";

}  // namespace

std::string numbered_file(std::uint32_t number) {
  return fmt::format("{}{:06}{}", kBegin, number, kEnd);
}

std::optional<std::uint32_t> file_number(std::string_view name) {
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return std::nullopt;
  if (name.size() <= kBegin.size() + kEnd.size()) return std::nullopt;
  name = name.substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool good = error == std::errc() && end == name.data() + name.size();
  return good ? std::optional(number) : std::nullopt;
}

LogFiles log_files(const fs::path& folder) {
  LogFiles files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    files.current = files.current || name == kCurrentFile;
    if (const auto number = file_number(name)) files.numbers.push_back(*number);
  }
  std::ranges::sort(files.numbers);
  return files;
}

std::vector<fs::path> log_paths(const fs::path& folder) {
  const LogFiles files = log_files(folder);
  std::vector<fs::path> paths;
  paths.reserve(files.numbers.size() + 1);
  for (const std::uint32_t number : files.numbers) paths.push_back(folder / numbered_file(number));
  if (files.current) paths.push_back(folder / kCurrentFile);
  return paths;
}

fs::path folder_to_write() {
  if (const std::string given = tims::os::environment("LOGS_DIRECTORY"); !given.empty())
    return given.substr(0, given.find(':'));
  if (::geteuid() == 0) return kOfTheHost;
  if (const std::string state = tims::os::environment("XDG_STATE_HOME"); !state.empty())
    return fs::path(state) / "tims";
  return fs::path(tims::os::environment("HOME")) / ".local/state/tims";
}

fs::path folder_to_read() {
  const fs::path own = folder_to_write();
  return log_paths(own).empty() ? kOfTheHost : own;
}

}  // namespace rack::gdos
