// What a seed determines: the hosts of a fleet, and the steps of each round. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tims/address.h"
#include "tims/time.h"

namespace tims::chaos {

inline constexpr std::size_t kClientsPerHost = 2;

struct Host {
  std::string name;                    // "robot1-arm"
  std::optional<std::size_t> above{};  // the host of its super router
  Address router{};
  std::string line{};  // name of the line to the host above
};

struct Shape {
  std::vector<Host> hosts;  // the base, then each robot: its main host, its arm

  [[nodiscard]] std::size_t clients() const { return hosts.size() * kClientsPerHost; }
  [[nodiscard]] Address client_address(std::size_t client) const;
  // The next host on the path from `host` down to `below`; `host` itself if they are the same.
  // Nothing: `below` is not below `host`.
  [[nodiscard]] std::optional<std::size_t> next_down(std::size_t host, std::size_t below) const;
};
Shape make_shape(std::size_t robots);
// The fleet file. `client`: the command of a client, with {} for its number.
std::string fleet_file(const Shape& shape, const std::string& client);

struct Step {
  Duration at{};
  std::vector<std::string> arguments;  // arguments of `timsctl sim`
};
struct Round {
  Duration span{};
  bool kills = false;       // in every second round; in the others all losses must be counted
  std::vector<Step> steps;  // in the order of their times
};
Round plan_round(std::uint64_t seed, std::size_t number, const Shape& shape, Duration span_max);
// Steps that end all faults of a round.
std::vector<Step> healing(const Shape& shape);

}  // namespace tims::chaos
