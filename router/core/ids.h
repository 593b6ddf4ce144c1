// Who is meant: kinds of ports and clients.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "router/core/labels.h"

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

inline constexpr std::size_t kClasses = 8;  // of messages, by priority: priority_classes.h

}  // namespace tims::core
