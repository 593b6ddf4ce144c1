// Devices in the network: a TCP connection, or datagrams of UDP.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

// Waits for the connection, 1 s at most.
tims::Result<std::unique_ptr<Transport>> open_tcp(const DeviceAddress& address);
// Receives at the port; sends to place:port, where the address has a place, else to who was heard
// last. Datagrams of others than a place that is given are left out.
tims::Result<std::unique_ptr<Transport>> open_udp(const DeviceAddress& address);

}  // namespace rack::device
