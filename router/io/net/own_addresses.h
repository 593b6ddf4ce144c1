// Where other hosts may reach a socket of this host.
#pragma once

#include <vector>

#include "router/link/net_address.h"

namespace tims::io {

// `local`: what the socket is bound to. Of a socket that is bound to all addresses, one for each
// address of an interface that has a carrier: not those of the link's own scope, which mean nothing
// elsewhere, and loopback only when there is nothing else.
std::vector<link::NetAddress> own_addresses(const link::NetAddress& local);

}  // namespace tims::io
