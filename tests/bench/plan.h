// What one process of a measurement is told: its role and the sizes, as `--key value` arguments.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"

namespace tims::bench {

struct Plan {
  std::string role;      // "ping", "echo", "source", "sink", "pulse", "gauge", or one alone
  std::string link;      // how it reaches the others: "tims", "ring", "tcp", ...
  std::string folder;    // scratch of this measurement
  std::string socket;    // of the router
  std::string endpoint;  // "host:port" of the router, the relay or the other end
  std::string host;      // numeric address of this one, where there are two
  std::size_t payload = 64;
  std::uint64_t window = 64;      // messages that may be under way
  std::uint32_t subscribers = 1;  // of one source
  std::uint32_t index = 0;        // of this subscriber
  std::uint32_t pair = 0;         // several pairs may run side by side
  std::uint32_t priority = 0;     // of what is sent
  std::uint64_t count = 0;        // of mailboxes or routers, where a role asks for a number
  Duration seconds = std::chrono::milliseconds(500);
  Duration every = std::chrono::milliseconds(5);  // of what has a period

  // Streams are gathered and may wait a moment before they sleep; round trips are sent at once.
  [[nodiscard]] bool streaming() const { return role == "source" || role == "sink"; }
  [[nodiscard]] bool sender() const {
    return role == "ping" || role == "source" || role == "pulse";
  }
};

// Both ways.
std::vector<std::string> to_arguments(const Plan& plan);
Result<Plan> parse_plan(std::span<const std::string> arguments);

// 4 MiB, but between 4 and 4096 messages: the same for every peer.
constexpr std::uint64_t window_of(std::size_t payload) {
  const std::uint64_t messages = (std::uint64_t{4} << 20) / payload;
  return messages < 4 ? 4 : messages > 4096 ? 4096 : messages;
}

// Room at a receiver. A round trip needs one; the others show what going round costs.
inline std::uint64_t slots_of(const Plan& plan) {
  constexpr std::uint64_t kRoundTrip = 16;
  const bool many = plan.streaming() || plan.role == "gauge";
  return many || plan.window < kRoundTrip ? plan.window : kRoundTrip;
}

}  // namespace tims::bench
