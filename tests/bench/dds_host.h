// Before a DDS participant is made: it only ever knows the interfaces that run by then.
#pragma once

#include <string>

namespace tims::bench {

// Until the interface with this address runs; the kernel takes up to a second to say so of a new
// one. Not for ever: then there is no such address.
void wait_for_interface(const std::string& address);

}  // namespace tims::bench
