#include "tests/bench/metrics.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace tims::bench {
namespace {

constexpr std::string_view kMark = "metric ";
constexpr double kMillion = 1e6;

bool is_rate(std::string_view name) { return name.ends_with("_per_s"); }
bool is_sum(std::string_view name) { return name.starts_with("raw_") || name == "lost"; }

}  // namespace

void print_metric(std::string_view name, double value) {
  std::printf("metric %.*s %.9g\n", static_cast<int>(name.size()), name.data(), value);
  std::fflush(stdout);
}

Metrics parse_metrics(std::string_view output) {
  Metrics metrics;
  std::istringstream lines{std::string(output)};
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(kMark)) continue;
    std::istringstream fields(line.substr(kMark.size()));
    std::string name;
    double value = 0;
    if (fields >> name >> value) metrics[name] = value;
  }
  return metrics;
}

Metrics join(const std::vector<Metrics>& processes, std::uint32_t subscribers,
             std::uint32_t pairs) {
  std::map<std::string, std::vector<double>> found;
  for (const Metrics& metrics : processes) {
    for (const auto& [name, value] : metrics) found[name].push_back(value);
  }
  Metrics joined;
  for (const auto& [name, values] : found) {
    double sum = 0;
    for (const double value : values) sum += value;
    if (is_sum(name) || (is_rate(name) && pairs > 1)) {
      joined[name] = sum;
    } else {
      joined[name] = *std::min_element(values.begin(), values.end());
    }
  }
  if (const double messages = joined[raw::kCount] / subscribers; messages > 0) {
    joined["cpu_s"] = joined[raw::kCpu] / messages * kMillion;
    joined["sleeps_per_million"] = joined[raw::kSleeps] / messages * kMillion;
    if (joined.contains(raw::kSystemCalls))
      joined["syscalls_per_million"] = joined[raw::kSystemCalls] / messages * kMillion;
  }
  std::erase_if(joined, [](const auto& entry) { return entry.first.starts_with("raw_"); });
  return joined;
}

double received_bytes(const std::string& net_dev, std::string_view device) {
  std::istringstream lines(net_dev);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    std::istringstream fields(line.substr(0, colon));
    std::string name;
    double bytes = 0;
    if (colon != std::string::npos && fields >> name && name == device &&
        std::istringstream(line.substr(colon + 1)) >> bytes)
      return bytes;
  }
  return 0;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

Metrics medians(const std::vector<Metrics>& repetitions) {
  std::map<std::string, std::vector<double>> found;
  for (const Metrics& metrics : repetitions) {
    for (const auto& [name, value] : metrics) found[name].push_back(value);
  }
  Metrics result;
  for (auto& [name, values] : found) result[name] = median(std::move(values));
  return result;
}

void print_latencies(std::vector<Duration>& samples) {
  if (samples.empty()) return;
  std::sort(samples.begin(), samples.end());
  const auto quantile_us = [&](double q) {
    const auto at = static_cast<std::size_t>(q * static_cast<double>(samples.size()));
    return static_cast<double>(samples[std::min(at, samples.size() - 1)].count()) * 1e-3;
  };
  print_metric("p50_us", quantile_us(0.5));
  print_metric("p99_us", quantile_us(0.99));
  if (samples.size() >= 1000) print_metric("p999_us", quantile_us(0.999));
}

}  // namespace tims::bench
