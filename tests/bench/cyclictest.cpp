#include "tests/bench/cyclictest.h"

#include <cstdio>
#include <filesystem>
#include <sstream>
#include <vector>

#include "tests/bench/components.h"
#include "tests/bench/launch.h"
#include "tests/bench/metrics.h"

namespace tims::bench {
namespace {

constexpr const char* kProgram = "/usr/bin/cyclictest";
constexpr int kCyclictestLatestUs = 50'000;

std::string number(auto value) { return std::to_string(value); }

// Lines "000012 000345": delay in us, number of samples.
std::vector<Duration> samples_of(const std::string& histogram) {
  std::vector<Duration> samples;
  std::istringstream lines(histogram);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::int64_t late_us = 0;
    std::size_t count = 0;
    if (fields >> late_us >> count)
      samples.insert(samples.end(), count, Duration(std::chrono::microseconds(late_us)));
  }
  return samples;
}

}  // namespace

bool has_cyclictest() { return std::filesystem::exists(kProgram); }

bool run_cyclictest(const Plan& plan) {
  using std::chrono::duration_cast;
  const auto period = duration_cast<std::chrono::microseconds>(plan.every).count();
  auto process = launch({kProgram, "--quiet", "--mlockall", "--threads=1", "--affinity=0",
                         "--priority=" + number(kRealTimePriority), "--interval=" + number(period),
                         "--loops=" + number(plan.seconds / plan.every),
                         "--histogram=" + number(kCyclictestLatestUs)},
                        false);
  if (!process) return false;
  const auto ended = process->wait(plan.seconds + kStartLimit);
  std::vector<Duration> samples = samples_of(process->standard_output());
  if (!ended || !ended->success() || samples.empty()) {
    std::fprintf(stderr, "cyclictest: %s", process->output().c_str());
    return false;
  }
  print_latencies(samples);
  return true;
}

}  // namespace tims::bench
