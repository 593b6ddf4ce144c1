// A CAN bus behind a USB adapter that speaks text (core/slcan.h): "serial:/dev/ttyACM0?can=500000".
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

// line: to the adapter.
tims::Result<std::unique_ptr<Transport>> open_slcan(std::unique_ptr<Transport> line,
                                                    std::uint32_t bit_rate);

}  // namespace rack::device
