// Serial lines, and pseudo terminals that stand in for them.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

tims::Result<std::unique_ptr<Transport>> open_serial(const DeviceAddress& address,
                                                     std::uint32_t baud);
// A terminal of its own, whose other end `place` becomes a link to: an emulator opens it.
tims::Result<std::unique_ptr<Transport>> open_pty(const DeviceAddress& address, std::uint32_t baud);

}  // namespace rack::device
