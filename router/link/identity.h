// Who a router is, and what two routers are to each other.
#pragma once

#include <cstdint>

#include "router/core/ids.h"
#include "router/core/message.h"
#include "router/core/text.h"
#include "tims/address.h"

namespace tims::link {

using core::LinkKind;
using core::Role;

// Who a router is. `epoch` is drawn at random when it starts.
struct Identity {
  std::uint64_t epoch = 0;
  Role role = Role::kSystem;
  std::uint8_t system = 0;
  std::uint8_t id = 0;
  core::Text<63> name{};
  AddressWidths widths{};
  std::uint32_t message_max = 0;  // bytes, header included
  core::PriorityClasses classes{};

  [[nodiscard]] Address address() const {
    return Address::of({.system = system, .instance = id}, widths);
  }
  bool operator==(const Identity&) const = default;
};

// Whether `who` is what a router like `below` looks for above it: the system router of its system,
// or a top-level one.
inline bool is_above(const Identity& who, const Identity& below) {
  if (below.role == Role::kSubsystem)
    return who.role == Role::kSystem && who.system == below.system;
  return below.role == Role::kSystem && who.role == Role::kTop;
}

}  // namespace tims::link
