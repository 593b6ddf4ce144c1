#include "tests/bench/crew.h"

#include <filesystem>

#include "libtims/os/clock.h"
#include "tests/bench/launch.h"
#include "tests/bench/trace.h"

namespace tims::bench {

Crew::Crew(const Setting& setting, const Experiment& experiment)
    : setting_(setting),
      experiment_(experiment),
      folder_(setting.folder + "/now"),
      middle_(setting, experiment, folder_) {
  std::filesystem::create_directory(folder_);
}

Crew::~Crew() {
  members_.clear();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

Result<void> Crew::start_middle() {
  auto started = middle_.start();
  before_ = middle_.usage();
  return started;
}

Result<void> Crew::start(Plan plan) {
  const Place& place = plan.sender() ? middle_.of_senders() : middle_.of_receivers();
  plan.folder = folder_;
  plan.socket = place.socket;
  plan.endpoint = place.endpoint;
  plan.host = place.address;
  std::vector<std::string> command = place.enter;
  std::string trace;
  if (experiment_.traced) {
    trace = folder_ + "/trace-" + plan.role;
    command = traced(trace);
  }
  command.push_back(setting_.program);
  for (std::string& argument : to_arguments(plan)) command.push_back(std::move(argument));
  auto process = launch(std::move(command), experiment_.one_cpu);
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
  if (!middle_.empty()) {
    const Usage spent = middle_.usage() - before_;
    results.push_back({{raw::kCpu, spent.cpu_s}, {raw::kSleeps, spent.sleeps}});
  }
  return results;
}

Result<Metrics> Crew::result_of(Member& member, Duration limit) const {
  auto status = member.process.wait(limit);
  if (!status) return status.error();
  if (!status->success()) {
    return Error(Errc::kSystem, member.role + ": " + status->to_string() + ": " +
                                    member.process.output() + middle_.output());
  }
  Metrics metrics = parse_metrics(member.process.standard_output());
  if (!member.trace.empty()) metrics.merge(counted(member.trace));
  return metrics;
}

}  // namespace tims::bench
