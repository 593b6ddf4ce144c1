#include "tests/chaos/fleet.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "tests/support/patience.h"
#include "tools/cli/failure.h"
#include "tools/sim/plan.h"
#include "tools/sim/supervisor.h"

namespace tims::chaos {
namespace {

namespace fs = std::filesystem;
namespace sim = timsctl::sim;
using timsctl::Exit;
using timsctl::Failure;

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

timsctl::Ran run_timsctl(std::vector<std::string> words) {
  words.insert(words.begin(), TIMSCTL_PROGRAM);
  return timsctl::run({.command = std::move(words), .environment = {"TIMS_HOST="}});
}

}  // namespace

Fleet::Fleet(std::string name, const std::string& file, const std::string& folder)
    : name_(std::move(name)),
      log_(folder + "/fleet.log"),
      child_(timsctl::start(
          {.command = {TIMSCTL_PROGRAM, "sim", "up", file, "--fleet", name_, "--json"},
           .log = log_})) {
  for (;;) {
    const bool gone = child_.has_ended(std::chrono::milliseconds(20));
    if (content_of(log_).find("\"linked\"") != std::string::npos) return;
    if (!gone) continue;
    const int code = child_.reap().as_shell();
    throw Failure(code == 5 ? Exit::kDenied : Exit::kNo, "no_fleet", content_of(log_));
  }
}

Fleet::~Fleet() {
  if (up_) take_down();
}

void Fleet::sim(std::vector<std::string> words) const {
  words.insert(words.begin(), "sim");
  words.insert(words.end(), {"--fleet", name_});
  const std::string text = fmt::format("timsctl {}", fmt::join(words, " "));
  const timsctl::Ran ran = run_timsctl(std::move(words));
  if (!ran.status.success()) throw Failure(Exit::kNo, "sim", text + ": " + ran.output);
}

std::vector<std::string> Fleet::ended() const {
  std::vector<std::string> lines;
  std::ifstream file(log_);
  for (std::string line; std::getline(file, line);)
    if (line.find(R"("event":"ended")") != std::string::npos) lines.push_back(line);
  return lines;
}

std::vector<pid_t> Fleet::processes() const {
  std::vector<pid_t> all;
  for (const std::string& network : sim::networks_of(name_))
    for (const pid_t pid : os::processes_in(network)) all.push_back(pid);
  return all;
}

void Fleet::save(const std::string& folder) const {
  for (const auto& entry : fs::recursive_directory_iterator(sim::folder_of(name_))) {
    if (!entry.is_regular_file()) continue;
    const fs::path to = folder / fs::relative(entry.path(), sim::folder_of(name_));
    fs::create_directories(to.parent_path());
    fs::copy(entry.path(), to, fs::copy_options::overwrite_existing);
  }
}

std::vector<std::string> Fleet::take_down() {
  up_ = false;
  std::vector<std::string> left;
  const std::vector<pid_t> pids = processes();
  const timsctl::Ran down = run_timsctl({"sim", "down", name_});
  if (!down.status.success()) left.push_back("timsctl sim down: " + down.output);
  if (!child_.has_ended(test::kPatience))
    left.emplace_back("the process of the fleet does not end");
  for (const std::string& network : sim::networks_of(name_)) left.push_back("namespace " + network);
  if (fs::exists(sim::folder_of(name_))) left.push_back(sim::folder_of(name_));
  for (const pid_t pid : pids)
    if (::kill(pid, 0) == 0) left.push_back(fmt::format("process {}", pid));
  return left;
}

std::string Fleet::socket(const std::string& host) const {
  return fmt::format("{}/{}/router.sock", sim::folder_of(name_), host);
}

}  // namespace tims::chaos
