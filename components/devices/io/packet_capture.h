// A packet capture (pcap, pcapng) as a recording: payloads of UDP and TCP.
#pragma once

#include "rack/devices/recording.h"

namespace rack::device {

// `port`: for TCP the port of the device, for UDP that of the receiver; 0: all ports. Fails if the
// file or its type of packets cannot be read.
Result<std::unique_ptr<Recording>> open_packet_capture(const std::string& path, std::uint16_t port);

}  // namespace rack::device
