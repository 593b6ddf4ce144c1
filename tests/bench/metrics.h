// Metrics of one measurement by name; processes print them to stdout, one per line, and those of
// several processes are joined.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tims/time.h"

namespace tims::bench {

using Metrics = std::map<std::string, double>;

// Names that are joined but not shown.
namespace raw {
inline constexpr const char* kCpu = "raw_cpu_s";
inline constexpr const char* kSleeps = "raw_sleeps";
inline constexpr const char* kSystemCalls = "raw_system_calls";
inline constexpr const char* kCount = "raw_count";
}  // namespace raw

// "metric NAME VALUE"
void print_metric(std::string_view name, double value);
Metrics parse_metrics(std::string_view output);

// Sums losses and costs; a rate is that of the slowest subscriber, summed over `pairs`. CPU seconds
// (cpu_s), sleeps and system calls are converted to values per million messages.
Metrics join(const std::vector<Metrics>& processes, std::uint32_t subscribers, std::uint32_t pairs);

// Received bytes of a device in the text of /proc/net/dev; 0: no such device.
double received_bytes(const std::string& net_dev, std::string_view device);

double median(std::vector<double> values);
Metrics medians(const std::vector<Metrics>& repetitions);

// Prints p50_us, p99_us and, from 1000 samples on, p999_us.
void print_latencies(std::vector<Duration>& samples);

}  // namespace tims::bench
