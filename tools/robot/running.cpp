#include "tools/robot/running.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "os/environment.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/robot/robot_file.h"

namespace timsctl::robot {

namespace {

namespace fs = std::filesystem;

// Where only this user may write.
std::string all_robots() {
  if (const std::string runtime = tims::os::environment("XDG_RUNTIME_DIR"); !runtime.empty())
    return runtime + "/tims-robots";
  if (::geteuid() == 0) return "/run/tims-robots";
  return fmt::format("/tmp/tims-robots-{}", ::geteuid());
}

}  // namespace

std::string key_of(std::string_view name, std::string_view router) {
  std::uint32_t hash = 2166136261;  // FNV-1a
  for (const char c : router) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619;
  return fmt::format("{}@{:08x}", name, hash);
}

std::string_view name_of(std::string_view key) { return key.substr(0, key.find('@')); }

std::string folder_of(std::string_view robot) { return fmt::format("{}/{}", all_robots(), robot); }
std::string control_socket(std::string_view robot) { return folder_of(robot) + "/control.sock"; }
std::string status_socket(std::string_view robot) { return folder_of(robot) + "/status.sock"; }
std::string log_file(std::string_view robot) { return folder_of(robot) + "/log"; }

std::vector<std::string> running() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(all_robots(), ignored))
    if (const std::string name = entry.path().filename(); is_running(name)) names.push_back(name);
  std::ranges::sort(names);
  return names;
}

std::string chosen(std::string_view name, std::string_view router) {
  std::vector<std::string> found;
  for (std::string& key : running()) {
    if (key == name || key == key_of(name, router)) return key;
    if (name.empty() || name == name_of(key)) found.push_back(std::move(key));
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1)
    throw usage_error(fmt::format("several robots run: {}", fmt::join(found, ", ")),
                      "say which one: `timsctl down NAME`, with the -H of its `up` or as here");
  if (name.empty())
    throw Failure(Exit::kNoSuch, "no_such_robot", "no robot runs on this host",
                  "`timsctl up FILE` starts one");
  throw Failure(Exit::kNoSuch, "no_such_robot", fmt::format("robot {} does not run", name),
                "`timsctl robot` shows those that do");
}

bool is_running(std::string_view robot) { return somebody_listens(control_socket(robot)); }

json::object ask(std::string_view robot, const json::object& question, const Signals& signals,
                 tims::Duration timeout) {
  return ask_control(
      control_socket(robot), question, signals, timeout,
      {Exit::kNoSuch, "no_such_robot", fmt::format("robot {} does not run", name_of(robot)),
       "`timsctl up FILE` starts one"});
}

}  // namespace timsctl::robot
