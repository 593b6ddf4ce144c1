// A CAN interface as the kernel has it set up, asked and told by netlink.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "tims/result.h"

namespace rack::device {

struct CanLink {
  bool is_hardware = false;                 // else there is no bit rate: vcan
  std::optional<std::uint32_t> bit_rate{};  // nothing: it was never set
  std::string state{};                      // of its controller: "error-active", "bus-off"
};

// Of the kernel's answer about one interface; whatever is not in it is left out.
CanLink parse_can_link(std::span<const std::byte> message);
tims::Result<CanLink> can_link(unsigned interface_index);

// Sends its controller back to the bus after bus-off, as `ip link set can0 type can restart`.
// kSystem without the right (CAP_NET_ADMIN), and where the kernel does it by itself (restart-ms).
tims::Result<void> restart_can(unsigned interface_index);

}  // namespace rack::device
