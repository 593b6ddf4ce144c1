#include "tests/bench/crew.h"

#include <filesystem>

#include <sched.h>

#include "libtims/os/clock.h"
#include "tests/bench/trace.h"

namespace tims::bench {
namespace {

constexpr Duration kStartLimit = std::chrono::seconds(10);

// Children inherit the CPUs of the thread that starts them.
class OnLastCpu {
 public:
  OnLastCpu() {
    ::sched_getaffinity(0, sizeof all_, &all_);
    cpu_set_t last;
    CPU_ZERO(&last);
    for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &all_)) continue;
      CPU_ZERO(&last);
      CPU_SET(cpu, &last);
    }
    ::sched_setaffinity(0, sizeof last, &last);
  }
  ~OnLastCpu() { ::sched_setaffinity(0, sizeof all_, &all_); }
  OnLastCpu(const OnLastCpu&) = delete;
  OnLastCpu& operator=(const OnLastCpu&) = delete;

 private:
  cpu_set_t all_{};
};

std::vector<std::string> router_command(const Setting& setting, const std::string& socket) {
  // A queue that holds every window of any scenario: what a measurement loses is a mistake.
  return {setting.router,           "--set", "unix.path=" + socket, "--set",
          "tcp.listen=127.0.0.1:0", "--set", "http.listen=off",     "--set",
          "tcp.queue=16MiB"};
}

}  // namespace

Crew::Crew(const Setting& setting, const Experiment& experiment)
    : setting_(setting),
      experiment_(experiment),
      folder_(setting.folder + "/now"),
      socket_(folder_ + "/router.sock") {
  std::filesystem::create_directory(folder_);
}

Crew::~Crew() {
  members_.clear();
  between_.clear();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Result<test::ChildProcess> Crew::launch(std::vector<std::string> command) const {
  if (!experiment_.one_cpu) return test::ChildProcess::start(std::move(command));
  const OnLastCpu pinned;
  return test::ChildProcess::start(std::move(command));
}

Result<void> Crew::start_between() {
  if (experiment_.between == Between::kNothing) return {};
  const bool relay = experiment_.between == Between::kRelay;
  const std::vector<std::string> relay_command{setting_.program, "--role", "relay"};
  auto process = launch(relay ? relay_command : router_command(setting_, socket_));
  if (!process) return process.error();
  constexpr std::string_view kListening = "listening tcp ";
  auto line = process->wait_for_line(kListening, kStartLimit);
  if (!line) return line.error();
  endpoint_ = line->substr(line->find(kListening) + kListening.size());
  endpoint_ = endpoint_.substr(0, endpoint_.find_first_of(" ,\t"));
  between_before_ = usage_of(process->pid());
  between_.push_back(std::move(*process));
  return {};
}

Result<void> Crew::start(Plan plan) {
  plan.folder = folder_;
  plan.socket = socket_;
  plan.endpoint = endpoint_;
  std::vector<std::string> command;
  std::string trace;
  if (experiment_.traced) {
    trace = folder_ + "/trace-" + plan.role;
    command = traced(trace);
  }
  command.push_back(setting_.program);
  for (std::string& argument : to_arguments(plan)) command.push_back(std::move(argument));
  auto process = launch(std::move(command));
  if (!process) return process.error();
  if (auto ready = process->wait_for_line("ready", kStartLimit); !ready) return ready.error();
  members_.push_back({plan.role, std::move(*process), std::move(trace)});
  return {};
}

Result<std::vector<Metrics>> Crew::wait(Duration limit) {
  const Time deadline = os::now() + limit;
  std::vector<Metrics> results;
  for (Member& member : members_) {
    auto result = result_of(member, std::max(Duration::zero(), deadline - os::now()));
    if (!result) return result.error();
    results.push_back(std::move(*result));
  }
  if (!between_.empty()) {
    const Usage spent = usage_of(between()) - between_before_;
    results.push_back({{raw::kCpu, spent.cpu_s}, {raw::kSleeps, spent.sleeps}});
  }
  return results;
}

Result<Metrics> Crew::result_of(Member& member, Duration limit) const {
  auto status = member.process.wait(limit);
  if (!status) return status.error();
  if (!status->success()) {
    std::string text = member.role + ": " + status->to_string() + ": " + member.process.output();
    if (!between_.empty()) text += between_.front().output();
    return Error(Errc::kSystem, std::move(text));
  }
  Metrics metrics = parse_metrics(member.process.standard_output());
  if (!member.trace.empty()) metrics.merge(counted(member.trace));
  return metrics;
}

}  // namespace tims::bench
