// A CAN interface, raw frames by SocketCAN.
//
// Error frames of the controller arrive as frames with the error flag, whatever is wanted. What
// cannot be sent at once waits in a small queue (CanQueue), 100 ms at most.
#pragma once

#include <vector>

#include "devices/io/transport.h"

namespace rack::device {

// `wanted`: frames that fit any of them; none: no frames at all.
tims::Result<std::unique_ptr<Transport>> open_can(const DeviceAddress& address,
                                                  const std::vector<CanFilter>& wanted);

}  // namespace rack::device
