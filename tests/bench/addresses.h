// Addresses of a measurement: one instance per pair; local id 0 is its sender, higher ones
// receivers. Of two hosts, senders are at the robot, system 1, and the base takes nothing else from
// it.
#pragma once

#include <cstdint>

#include "tests/bench/plan.h"
#include "tims/message.h"

namespace tims::bench {

inline Address sender_address(std::uint32_t pair) {
  return Address::of({.system = 1, .class_id = class_id::kTest, .instance = pair});
}
inline Address receiver_address(std::uint32_t pair, std::uint32_t index) {
  return Address::of({.class_id = class_id::kTest, .instance = pair, .local = index + 1});
}

// The header of messages that a process sends over TCP or UDP.
inline Header message_header(const Plan& plan) {
  const Address sender = sender_address(plan.pair);
  const Address receiver = receiver_address(plan.pair, plan.index);
  return {.type = type::kData,
          .dest = plan.sender() ? receiver : sender,
          .src = plan.sender() ? sender : receiver};
}

// UDP ports on two hosts: a router or relay and its client, alone in their namespaces.
inline constexpr const char* kRouterPort = ":2010";
inline constexpr const char* kClientPort = ":3000";

}  // namespace tims::bench
