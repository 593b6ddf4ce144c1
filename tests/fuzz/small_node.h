// A simulated router with little memory, so that a fuzzer also fills it.
#pragma once

#include <utility>
#include <vector>

#include "tests/sim/simulated_network.h"

namespace tims::fuzz {

inline sim::NodeSetup small_node(const char* name, core::Role role, std::uint8_t system,
                                 std::vector<link::LinkSettings> links) {
  return {.name = name,
          .role = role,
          .system = system,
          .links = std::move(links),
          .block_bytes = 1U << 20,
          .message_bytes = 1U << 20,
          .message_max = 1U << 16};
}

}  // namespace tims::fuzz
