// The limit of a router: a bare epoll loop between pairs of TCP clients. It looks at nothing and
// knows nobody; what one side sent is written to the other at once, as much as was there. A slow
// reader holds it up.
#pragma once

namespace tims::bench {

// Says where it listens as the router does, then relays until it is killed. A client's first
// message registers an address; addresses of one pair (addresses.h) belong together.
bool run_relay();

}  // namespace tims::bench
