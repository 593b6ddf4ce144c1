// Call before creating a DDS participant, which uses only interfaces that are up at that time.
#pragma once

#include <string>

namespace tims::bench {

// Waits until the interface with this address is up, which takes the kernel up to a second for a
// new one. Returns after a timeout if there is no such address.
void wait_for_interface(const std::string& address);

}  // namespace tims::bench
