// Who is who in a measurement: an instance a pair, local id 0 its sender, above that receivers.
#pragma once

#include <cstdint>

#include "tests/bench/plan.h"
#include "tims/message.h"

namespace tims::bench {

inline Address sender_address(std::uint32_t pair) {
  return Address::of({.class_id = class_id::kTest, .instance = pair});
}
inline Address receiver_address(std::uint32_t pair, std::uint32_t index) {
  return Address::of({.class_id = class_id::kTest, .instance = pair, .local = index + 1});
}

// Of what one process of a measurement sends over TCP or UDP.
inline Header message_header(const Plan& plan) {
  const Address sender = sender_address(plan.pair);
  const Address receiver = receiver_address(plan.pair, plan.index);
  return {.type = type::kData,
          .dest = plan.sender() ? receiver : sender,
          .src = plan.sender() ? sender : receiver};
}

// Of UDP on two hosts: a router or relay and its client. Nobody else is there.
inline constexpr const char* kRouterPort = ":2010";
inline constexpr const char* kClientPort = ":3000";

}  // namespace tims::bench
