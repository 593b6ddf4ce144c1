// Bare UDP between two hosts, as fast as the kernel takes it: bursts of datagrams in one call
// (UDP_SEGMENT), and put together again on the other side (UDP_GRO).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <netinet/in.h>

#include "libtims/os/file.h"
#include "tims/result.h"

namespace tims::bench {

// Bound to "host:port", with room for every window of any scenario.
Result<os::File> open_udp(const std::string& endpoint);
Result<sockaddr_in> udp_address(const std::string& endpoint);

// The socket is connected. Both spans as one stream of full datagrams.
bool send_trains(const os::File& socket, std::span<const std::byte> first,
                 std::span<const std::byte> second);

// The limit of a pair of routers: what the client of this host (kClientPort) sends goes to the
// relay at `endpoint`, and what comes from there to the client. Runs until it is killed.
bool run_udp_relay(const std::string& host, const std::string& endpoint);

}  // namespace tims::bench
