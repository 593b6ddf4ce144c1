// What routers are, and what two of them are to each other.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "router/core/labels.h"
#include "tims/address.h"

namespace tims::core {

enum class Role : std::uint8_t { kSubsystem, kSystem, kTop };
constexpr std::array kRoles{
    Label<Role>{Role::kSubsystem, "subsystem", "the router of one host of a robot"},
    Label<Role>{Role::kSystem, "system", "the highest router of a robot"},
    Label<Role>{Role::kTop, "top", "the router above all robots"},
};
static_assert(complete(kRoles, Role::kTop));
std::string_view name(Role role);

// What the other router is, seen from here.
enum class LinkKind : std::uint8_t { kSuper, kPeer, kSub };
constexpr std::array kLinkKinds{
    Label<LinkKind>{LinkKind::kSuper, "super", "the router above"},
    Label<LinkKind>{LinkKind::kPeer, "peer", "a router beside"},
    Label<LinkKind>{LinkKind::kSub, "sub", "a router below"},
};
static_assert(complete(kLinkKinds, LinkKind::kSub));
std::string_view name(LinkKind kind);

// The router that a mailbox lives at, as a link tells it.
struct Origin {
  Address router{};
  std::uint32_t epoch = 0;  // the lower half of that router's
  std::uint8_t hops = 0;    // links between it and us

  // The same router, and not one that has taken its place.
  [[nodiscard]] bool same_router(const Origin& other) const {
    return router == other.router && epoch == other.epoch;
  }
  bool operator==(const Origin&) const = default;
};

// A message or registration that has passed so many links goes round in a loop.
inline constexpr std::uint8_t kHopsMax = 16;

}  // namespace tims::core
