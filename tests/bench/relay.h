// The limit of a router: a bare epoll loop between pairs of TCP clients. It parses nothing; all
// bytes available from one side are written to the other immediately. A slow reader blocks it.
#pragma once

namespace tims::bench {

// Prints its endpoint like the router, then relays until it is killed. A client's first message
// registers an address; the two addresses of a pair (addresses.h) are connected.
bool run_relay();

}  // namespace tims::bench
