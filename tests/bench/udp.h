// Bare UDP between two hosts at the highest speed of the kernel: bursts of datagrams in one call
// (UDP_SEGMENT), which are merged on the other side (UDP_GRO).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <netinet/in.h>

#include "libtims/os/file.h"
#include "tims/result.h"

namespace tims::bench {

inline constexpr std::size_t kUdpDatagram = 1472;  // fills an Ethernet frame

// Bound to "host:port", with room for every window of any scenario.
Result<os::File> open_udp(const std::string& endpoint);
Result<sockaddr_in> udp_address(const std::string& endpoint);

// Sends both spans as one stream of datagrams of this size on a connected socket.
bool send_trains(const os::File& socket, std::size_t datagram, std::span<const std::byte> first,
                 std::span<const std::byte> second);

// The limit of a pair of routers: datagrams of the client of this host (kClientPort) are sent to
// the relay at `endpoint`, and datagrams from there to the client; between the relays they are
// sealed, if this is wanted: then those of clients leave room for it. Runs until it is killed.
bool run_udp_relay(const std::string& host, const std::string& endpoint, bool sealed);

}  // namespace tims::bench
