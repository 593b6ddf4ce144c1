#include "tools/sim/state.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "base/text.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/sim/network.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {

namespace {

namespace fs = std::filesystem;

// "tims-demo-base": "demo"; empty for names that are not ours.
std::string fleet_of_network(std::string_view network) {
  constexpr std::string_view kPrefix = "tims-";
  if (!network.starts_with(kPrefix)) return {};
  network.remove_prefix(kPrefix.size());
  const std::size_t dash = network.find('-');
  const std::string name(network.substr(0, dash));
  return dash != std::string_view::npos && is_fleet_name(name) ? name : std::string();
}

Failure not_running(std::string_view fleet) {
  return {Exit::kNoSuch, "no_such_fleet", fmt::format("fleet {} does not run", fleet),
          "`timsctl sim up FILE` starts one; `timsctl sim show` lists all"};
}

}  // namespace

std::string folder_of(std::string_view fleet) { return fmt::format("{}/{}", kSimFolder, fleet); }
std::string control_socket(std::string_view fleet) { return folder_of(fleet) + "/control.sock"; }

std::vector<std::string> fleets() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(kSimFolder, ignored))
    if (is_fleet_name(entry.path().filename().string())) names.push_back(entry.path().filename());
  for (const auto& entry : fs::directory_iterator("/run/netns", ignored))
    if (std::string name = fleet_of_network(entry.path().filename().string()); !name.empty())
      names.push_back(std::move(name));
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

bool is_running(std::string_view fleet) { return somebody_listens(control_socket(fleet)); }

json::object read_state(std::string_view fleet) {
  std::ifstream file(folder_of(fleet) + "/state.json");
  return parse_object(std::string(std::istreambuf_iterator<char>(file), {}));
}

void write_state(std::string_view fleet, const json::object& state) {
  const std::string path = folder_of(fleet) + "/state.json";
  std::ofstream(path + ".new") << to_text(state) << '\n';
  std::error_code ignored;  // readers see the old or the new one, never a half
  fs::rename(path + ".new", path, ignored);
}

bool clean_up(std::string_view fleet) {
  const auto networks = networks_of(fleet);
  remove_networks(networks);
  std::error_code ignored;
  const auto files = fs::remove_all(folder_of(fleet), ignored);
  return !networks.empty() || (files != 0 && files != static_cast<std::uintmax_t>(-1));
}

json::object ask_fleet(std::string_view fleet, const json::object& question, const Signals& signals,
                       tims::Duration timeout) {
  return ask_control(control_socket(fleet), question, signals, timeout, not_running(fleet));
}

std::string chosen_fleet(std::string_view name) {
  if (!name.empty()) {
    if (!is_fleet_name(name))
      throw usage_error(fmt::format("\"{}\" is no name of a fleet", name), "`timsctl sim show`");
    return std::string(name);
  }
  std::vector<std::string> running;
  for (std::string& fleet : fleets())
    if (is_running(fleet)) running.push_back(std::move(fleet));
  if (running.size() == 1) return running.front();
  if (running.empty())
    throw Failure(Exit::kNoSuch, "no_such_fleet", "no fleet runs on this host",
                  "`timsctl sim up FILE` starts one, as root");
  throw usage_error(fmt::format("several fleets run: {}", fmt::join(running, ", ")),
                    "say which one with --fleet NAME");
}

Failure no_such(std::string_view what, std::string_view name,
                std::span<const std::string_view> known) {
  const auto near = base::nearest(name, known);
  return {Exit::kNoSuch, fmt::format("no_such_{}", what), fmt::format("no {} \"{}\"", what, name),
          near ? fmt::format("did you mean {}?", *near)
               : fmt::format("there are {}", fmt::join(known, ", "))};
}

void need_root() {
  if (::geteuid() == 0) return;
  throw Failure(Exit::kDenied, "denied", "network namespaces are made by root only",
                "sudo timsctl sim ...");
}

}  // namespace timsctl::sim
