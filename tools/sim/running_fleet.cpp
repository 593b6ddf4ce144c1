#include "tools/sim/running_fleet.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/file.h"
#include "os/wakeup.h"
#include "tools/cli/failure.h"
#include "tools/sim/plan.h"
#include "tools/sim/supervisor.h"

namespace timsctl::sim {
namespace {

namespace fs = std::filesystem;

std::string content_of(const std::string& path) { return tims::os::read_file(path).value_or({}); }

}  // namespace

RunningFleet::RunningFleet(Options options)
    : options_(std::move(options)),
      child_(start({.command = {options_.timsctl, "sim", "up", options_.file, "--fleet",
                                options_.name, "--json"},
                    .log = options_.log})) {
  for (;;) {
    const bool gone = child_.has_ended(std::chrono::milliseconds(20));
    if (content_of(options_.log).find("\"linked\"") != std::string::npos) return;
    if (!gone) continue;
    const int code = child_.reap().as_shell();
    throw Failure(code == static_cast<int>(Exit::kDenied) ? Exit::kDenied : Exit::kNo, "no_fleet",
                  content_of(options_.log));
  }
}

RunningFleet::~RunningFleet() {
  if (up_) take_down();
}

Ran RunningFleet::run_timsctl(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), options_.timsctl);
  return run({.command = std::move(arguments), .environment = {"TIMS_HOST="}});
}

void RunningFleet::sim(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), "sim");
  arguments.insert(arguments.end(), {"--fleet", options_.name});
  const std::string text = fmt::format("timsctl {}", fmt::join(arguments, " "));
  const Ran ran = run_timsctl(std::move(arguments));
  if (!ran.status.success()) throw Failure(Exit::kNo, "sim", text + ": " + ran.output);
}

tims::Time RunningFleet::kill_router(const std::string& host) const {
  const json::object state = read_state(options_.name);
  pid_t pid = 0;
  for (const json::object& item : objects(items_of(state, "hosts")))
    if (text_at(item, "name") == host)
      for (const json::object& program : objects(items_of(item, "programs")))
        if (text_at(program, "name").find("router") != std::string::npos)
          pid = static_cast<pid_t>(number_or_zero(program, "pid"));
  const tims::os::File router(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0U)));
  const Process command =
      start({.command = {options_.timsctl, "sim", "kill", host, "router", "--fleet", options_.name},
             .environment = {"TIMS_HOST="},
             .log = options_.log});
  const bool gone = router && tims::os::is_readable(router.get(), options_.patience);
  const tims::Time when = tims::os::now();
  if (!gone || !command.has_ended(options_.patience) || !command.reap().success())
    throw Failure(Exit::kNo, "sim", fmt::format("cannot kill the router of {}", host),
                  options_.log);
  return when;
}

std::vector<std::string> RunningFleet::ended() const {
  std::vector<std::string> lines;
  std::ifstream file(options_.log);
  for (std::string line; std::getline(file, line);)
    if (line.find(R"("event":"ended")") != std::string::npos) lines.push_back(line);
  return lines;
}

std::vector<pid_t> RunningFleet::processes() const {
  std::vector<pid_t> all;
  for (const std::string& network : networks_of(options_.name))
    for (const pid_t pid : tims::os::processes_in(network)) all.push_back(pid);
  return all;
}

void RunningFleet::save(const std::string& folder) const {
  const std::string from = running_fleets().folder_of(options_.name);
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".key") continue;
    const fs::path to = folder / fs::relative(entry.path(), from);
    fs::create_directories(to.parent_path());
    fs::copy(entry.path(), to, fs::copy_options::overwrite_existing);
  }
}

std::vector<std::string> RunningFleet::take_down() {
  up_ = false;
  std::vector<std::string> left;
  const std::vector<pid_t> pids = processes();
  const Ran down = run_timsctl({"sim", "down", options_.name});
  if (!down.status.success()) left.push_back("timsctl sim down: " + down.output);
  if (!child_.has_ended(options_.patience))
    left.emplace_back("the process of the fleet has not ended");
  for (const std::string& network : networks_of(options_.name))
    left.push_back("namespace " + network);
  if (fs::exists(running_fleets().folder_of(options_.name)))
    left.push_back(running_fleets().folder_of(options_.name));
  for (const pid_t pid : pids)
    if (::kill(pid, 0) == 0) left.push_back(fmt::format("process {}", pid));
  return left;
}

std::string RunningFleet::socket(const std::string& host) const {
  return fmt::format("{}/{}/router.sock", running_fleets().folder_of(options_.name), host);
}

}  // namespace timsctl::sim
