// Common parts of the lists of scenarios.
#pragma once

#include <vector>

#include "tests/bench/scenarios.h"

namespace tims::bench {

inline constexpr std::size_t kKi = 1 << 10;
inline constexpr std::size_t kMi = 1 << 20;
inline constexpr double kMillion = 1e6;

struct Sizes {
  std::vector<std::size_t> round_trip{64, kKi, 64 * kKi, kMi};
  std::vector<std::size_t> stream{64, kKi, 64 * kKi, kMi};
  std::vector<std::size_t> hosts_round_trip{64, kKi, 64 * kKi};
};
inline Sizes sizes(bool quick) {
  if (!quick) return {};
  return {.round_trip = {64, kMi}, .stream = {64, 64 * kKi, kMi}, .hosts_round_trip = {64}};
}

inline const char* rate_metric(std::size_t payload) {
  return payload >= 64 * kKi ? "mb_per_s" : "msgs_per_s";
}

inline Experiment round_trip(const char* link, Between between, std::size_t payload, bool one_cpu) {
  return {.link = link, .between = between, .payload = payload, .one_cpu = one_cpu};
}
inline Experiment stream(const char* link, Between between, std::size_t payload) {
  return {.shape = Shape::kStream, .link = link, .between = between, .payload = payload};
}
inline Experiment pulse(const char* link, Between between, const Cable& cable,
                        std::size_t bulk = 0) {
  return {.shape = Shape::kPulse, .link = link, .between = between, .bulk = bulk, .cable = cable};
}

}  // namespace tims::bench
