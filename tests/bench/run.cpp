#include "tests/bench/run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>

#include <sys/resource.h>

#include "tests/bench/experiment.h"
#include "tests/bench/report.h"
#include "tests/bench/scenarios.h"
#include "tests/bench/scratch.h"

namespace tims::bench {
namespace {

Setting setting_of(const Options& options, const std::string& program, const std::string& folder) {
  using std::chrono::milliseconds;
  const auto length = [&](milliseconds usual, milliseconds quick) -> Duration {
    if (!options.seconds) return options.quick ? quick : usual;
    return Duration(static_cast<Duration::rep>(*options.seconds * 1e9));
  };
  return {.program = program,
          .router = std::filesystem::path(program).replace_filename("tims-router"),
          .folder = folder,
          .round_trip = length(milliseconds(300), milliseconds(200)),
          .stream = length(milliseconds(800), milliseconds(500)),
          .link = length(milliseconds(6000), milliseconds(2500))};
}

class Run {
 public:
  Run(const Options& options, const Setting& setting)
      : setting_(setting), reps_(options.reps.value_or(options.quick ? 1 : 3)) {}

  // Ours and the limits alternate, so that other load affects them equally.
  ResultsByPeer measure_case(const Case& one) {
    std::map<std::string, std::vector<Metrics>> repetitions;
    for (std::uint64_t rep = 0; rep < reps_; ++rep) {
      for (const Contender& contender : one.contenders) {
        if (auto metrics = try_twice(one, contender))
          repetitions[contender.peer].push_back(std::move(*metrics));
      }
    }
    ResultsByPeer results;
    for (const auto& [peer, metrics] : repetitions) results[peer] = medians(metrics);
    return results;
  }
  [[nodiscard]] int failures() const { return failures_; }

 private:
  Result<Metrics> try_twice(const Case& one, const Contender& contender) {
    auto metrics = measure(contender.experiment, setting_);
    if (!metrics) metrics = measure(contender.experiment, setting_);
    if (!metrics) {
      ++failures_;
      std::fprintf(stderr, "%s %s %zu: %s\n", contender.peer.c_str(), one.scenario.c_str(),
                   one.payload, metrics.error().message().c_str());
    }
    return metrics;
  }

  const Setting& setting_;
  std::uint64_t reps_;
  int failures_ = 0;
};

// A thousand clients need a thousand descriptors, here and in the router.
void allow_many_files() {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
}

// In the order in which they run; those that this machine does not support are reported and
// skipped.
std::vector<Case> chosen_cases(const Options& options) {
  std::vector<Case> cases = local_cases(options.quick);
  std::ranges::move(devices_cases(options.quick), std::back_inserter(cases));
  std::ranges::move(hosts_cases(options.quick), std::back_inserter(cases));
  std::erase_if(cases, [&](const Case& one) { return !options.selects(one.scenario); });
  const auto is_between_hosts = [](const Case& one) {
    return std::ranges::any_of(one.contenders, [](const Contender& contender) {
      return on_two_hosts(contender.experiment.between);
    });
  };
  if (std::ranges::none_of(cases, is_between_hosts)) return cases;
  remove_abandoned_hosts();
  if (const std::string why = why_no_hosts(); !why.empty()) {
    std::printf("Scenarios between hosts are skipped: %s.\n\n", why.c_str());
    std::erase_if(cases, is_between_hosts);
  }
  return cases;
}

}  // namespace

int run_bench(const Options& options, const std::string& program) {
  allow_many_files();
  const Scratch scratch;
  const Setting setting = setting_of(options, program, scratch.path());
  auto csv = Csv::open(options.csv);
  if (!csv) {
    std::fprintf(stderr, "tims-bench: %s\n", csv.error().message().c_str());
    return 2;
  }
  Run run(options, setting);
  const std::vector<Case> cases = chosen_cases(options);
  Table table;
  table.print_head();
  for (const Case& one : cases) {
    const ResultsByPeer results = run.measure_case(one);
    table.print(one, results);
    csv->write(one, results);
  }
  table.print_summary();
  if (run.failures() > 0) std::printf("%d measurements failed, see stderr\n", run.failures());
  return run.failures() > 0 ? 1 : 0;
}

}  // namespace tims::bench
