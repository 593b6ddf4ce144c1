// Reads and changes the kernel's settings of a CAN interface by netlink.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "tims/result.h"

namespace rack::device {

struct CanLink {
  bool is_hardware = false;                 // false for vcan, which has no bit rate
  std::optional<std::uint32_t> bit_rate{};  // empty if it was never set
  std::string state{};                      // of the controller: "error-active", "bus-off"
};

// Parses the kernel's answer about one interface; missing attributes stay empty.
CanLink parse_can_link(std::span<const std::byte> message);
tims::Result<CanLink> can_link(unsigned interface_index);

// Restarts the controller after bus-off, as `ip link set can0 type can restart`. Fails with kSystem
// without CAP_NET_ADMIN, and if the kernel restarts the controller itself (restart-ms).
tims::Result<void> restart_can(unsigned interface_index);

}  // namespace rack::device
