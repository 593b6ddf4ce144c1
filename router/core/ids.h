// Who is meant: clients, the kinds of ports they attach at, routers and what they are to each
// other.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "router/core/text.h"
#include "tims/address.h"

namespace tims::core {

// A client as long as it is connected. Numbers run on: the same number does not come back before
// four billion others.
struct ClientId {
  std::uint32_t value = 0;

  explicit constexpr operator bool() const { return value != 0; }
  auto operator<=>(const ClientId&) const = default;
};
inline constexpr ClientId kNoClient{};

enum class PortKind : std::uint8_t {
  kLocal,      // Unix socket and shared memory
  kTcp,        // original RACK programs and remote clients
  kWebSocket,  // browsers
  kRouter,     // the router itself: its admin answers
  kLink,       // another router
};
inline constexpr std::size_t kPortKindCount = 5;
// Not inline: lists with texts are read-only only as constants of each file that uses them.
constexpr std::array kPortKinds{
    Label<PortKind>{PortKind::kLocal, "local", "a program on this host"},
    Label<PortKind>{PortKind::kTcp, "tcp", "a program connected over TCP"},
    Label<PortKind>{PortKind::kWebSocket, "websocket", "a browser"},
    Label<PortKind>{PortKind::kRouter, "router", "the router itself"},
    Label<PortKind>{PortKind::kLink, "link", "another router"},
};
static_assert(complete(kPortKinds, PortKind::kLink) && kPortKinds.size() == kPortKindCount);
std::string_view name(PortKind port);

inline constexpr std::size_t kClasses = 8;  // of messages, by priority: message.h

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
