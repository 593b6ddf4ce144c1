// A CAN interface, raw frames by SocketCAN.
//
// Error frames of the controller arrive as frames with the error flag. What cannot be sent at once
// waits in a small queue by identifier, the lower first as on the bus itself; a frame that is older
// than 100 ms is dropped and counted: a motor must not hear yesterday's speed.
#pragma once

#include <vector>

#include "devices/io/transport.h"

namespace rack::device {

// (id & mask) == (wanted & mask) of any of them; none: all frames.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
};

tims::Result<std::unique_ptr<Transport>> open_can(const DeviceAddress& address,
                                                  const std::vector<CanFilter>& filters = {});

}  // namespace rack::device
