#include "tests/bench/usage.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <sys/resource.h>

#include "tests/bench/metrics.h"

namespace tims::bench {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// The number after "key:" in a file of /proc.
double number_of(const std::filesystem::path& file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1));
  }
  return 0;
}

std::filesystem::path folder_of(pid_t process) {
  return std::filesystem::path("/proc") / std::to_string(process);
}

}  // namespace

Usage own_usage() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime), static_cast<double>(usage.ru_nvcsw)};
}

Usage usage_of(pid_t process) {
  Usage usage;
  std::error_code gone;
  for (const auto& task : std::filesystem::directory_iterator(folder_of(process) / "task", gone)) {
    double on_cpu_ns = 0;  // first of schedstat: exact, where stat counts ticks of 10 ms
    std::ifstream(task.path() / "schedstat") >> on_cpu_ns;
    usage.cpu_s += on_cpu_ns * 1e-9;
    usage.sleeps += number_of(task.path() / "status", "voluntary_ctxt_switches");
  }
  return usage;
}

double resident_mb(pid_t process) {
  constexpr double kMbPerKib = 1024 * 1e-6;
  return number_of(folder_of(process) / "status", "VmRSS") * kMbPerKib;
}

void print_usage(const Usage& before, std::uint64_t messages) {
  const Usage spent = own_usage() - before;
  print_metric(raw::kCpu, spent.cpu_s);
  print_metric(raw::kSleeps, spent.sleeps);
  print_metric(raw::kCount, static_cast<double>(messages));
}

}  // namespace tims::bench
