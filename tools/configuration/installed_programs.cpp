#include "tools/configuration/installed_programs.h"

#include <algorithm>
#include <array>
#include <fstream>

#include <boost/json/parse.hpp>

#include "os/clock.h"
#include "os/environment.h"
#include "os/process.h"
#include "tools/robot/robot_file.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;

constexpr tims::Duration kListTime = std::chrono::seconds(1);

fs::path folder() { return fs::path(tims::os::find_program("timsctl")).parent_path(); }

// The names of the libraries that a program needs stand at its beginning.
bool names_library(const fs::path& path) {
  std::array<char, 64 << 10> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), static_cast<std::size_t>(file.gcount()));
  return head.starts_with(
             "\x7f"
             "ELF") &&
         head.find("librack") != std::string_view::npos;
}

bool is_program(const fs::path& path) {
  std::error_code error;
  return robot::is_name(path.filename().string()) && fs::is_regular_file(path, error) &&
         names_library(path);
}

std::optional<json::object> ask_program(const fs::path& path) {
  const auto ran = tims::os::run_to_end({.command = {path.string(), "--describe"}});
  boost::system::error_code error;
  const json::value value = json::parse(ran && ran->status.success() ? ran->output : "", error);
  if (error || !value.is_object() || !value.get_object().contains("rack_description"))
    return std::nullopt;
  return value.get_object();
}

}  // namespace

bool InstalledPrograms::is_known(const std::string& name) const {
  std::error_code error;
  const auto found = known_.find(name);
  return found != known_.end() &&
         found->second.written == fs::last_write_time(folder() / name, error);
}

const InstalledPrograms::Known* InstalledPrograms::known(const std::string& name) {
  if (!robot::is_name(name)) return nullptr;
  if (!is_known(name)) {
    const fs::path path = folder() / name;
    std::error_code error;
    if (!is_program(path)) {
      known_.erase(name);
      return nullptr;
    }
    Known fresh{.written = fs::last_write_time(path, error), .described = ask_program(path)};
    if (fresh.described) fresh.description = description_of(*fresh.described);
    known_[name] = std::move(fresh);
  }
  return &known_.at(name);
}

const json::object* InstalledPrograms::describe(const std::string& name) {
  const Known* found = known(name);
  return found != nullptr && found->described ? &*found->described : nullptr;
}

const Description* InstalledPrograms::find(const std::string& name) {
  const Known* found = known(name);
  return found != nullptr && found->description ? &*found->description : nullptr;
}

json::object InstalledPrograms::list() {
  std::error_code error;
  const auto written = fs::last_write_time(folder(), error);
  if (written != folder_written_) {
    names_.clear();
    for (const auto& entry : fs::directory_iterator(folder(), error))
      if (is_program(entry.path())) names_.push_back(entry.path().filename());
    std::ranges::sort(names_);
    folder_written_ = written;
  }
  const tims::Time end = tims::os::deadline_after(kListTime);
  json::array items;
  bool complete = true;
  for (const std::string& name : names_) {
    if (!is_known(name) && tims::os::now() > end) {
      complete = false;
      continue;
    }
    if (const json::object* described = describe(name))
      items.push_back(json::object{{"program", name},
                                   {"purpose", text_at(*described, "purpose")},
                                   {"class", text_at(*described, "class")}});
  }
  return {{"schema", "tims/conf_programs/1"}, {"items", std::move(items)}, {"complete", complete}};
}

}  // namespace timsctl::configuration
