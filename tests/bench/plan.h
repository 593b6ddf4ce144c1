// Parameters of one process of a measurement, passed as `--key value` arguments.
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
  std::string
      role;  // "ping", "echo", "source", "sink", "pulse", "gauge", "flood", or a single role
  std::string link;      // type of the link: "tims", "ring", "tcp", ...
  std::string folder;    // temporary folder of this measurement
  std::string socket;    // of the router
  std::string endpoint;  // "host:port" of the router, the relay or the other end
  std::string host;      // numeric address of this host, if there are two
  std::size_t payload = 64;
  std::uint64_t window = 64;      // messages that may be in flight
  std::uint32_t subscribers = 1;  // of one source
  std::uint32_t index = 0;        // of this subscriber
  std::uint32_t pair = 0;         // several pairs may run in parallel
  std::uint32_t priority = 0;     // of the messages
  std::uint64_t count = 0;        // number of mailboxes or routers, for roles that need it
  Duration seconds = std::chrono::milliseconds(500);
  Duration every = std::chrono::milliseconds(5);  // the period, if any

  // Messages of streams are collected, and receivers may poll before they sleep; round trips are
  // sent immediately.
  [[nodiscard]] bool streaming() const { return role == "source" || role == "sink"; }
  [[nodiscard]] bool sender() const {
    return role == "ping" || role == "source" || role == "pulse" || role == "flood";
  }
};

// Conversion to and from arguments.
std::vector<std::string> to_arguments(const Plan& plan);
Result<Plan> parse_plan(std::span<const std::string> arguments);

// 4 MiB, but between 4 and 4096 messages: the same for every peer.
constexpr std::uint64_t window_of(std::size_t payload) {
  const std::uint64_t messages = (std::uint64_t{4} << 20) / payload;
  return messages < 4 ? 4 : messages > 4096 ? 4096 : messages;
}

// Slots of a receiver. A round trip needs one; further ones show the cost of cycling through slots.
inline std::uint64_t slots_of(const Plan& plan) {
  constexpr std::uint64_t kRoundTrip = 16;
  const bool many = plan.streaming() || plan.role == "gauge";
  return many || plan.window < kRoundTrip ? plan.window : kRoundTrip;
}

}  // namespace tims::bench
