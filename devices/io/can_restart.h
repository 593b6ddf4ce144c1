// Sends the controller of a CAN interface back to its bus after bus-off.
#pragma once

#include "tims/result.h"

namespace rack::device {

// As `ip link set can0 type can restart`. kSystem without the right (CAP_NET_ADMIN), and where the
// kernel does it by itself (restart-ms).
tims::Result<void> restart_can(unsigned interface_index);

}  // namespace rack::device
