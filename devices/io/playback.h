// A recording instead of a device: what was received comes again, at the pace of then, and what was
// sent then as such (Arrival::is_sent); what is sent now goes nowhere. Captures, candump logs,
// packet captures (payloads of UDP and TCP), raw bytes; a folder of pictures (.jpg) as a camera's
// frames.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

// `baud`: the pace of raw bytes.
tims::Result<std::unique_ptr<Transport>> open_playback(const DeviceAddress& address,
                                                       std::uint32_t baud);

}  // namespace rack::device
