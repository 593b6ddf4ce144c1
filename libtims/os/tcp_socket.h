// TCP connections to a router.
#pragma once

#include <cstdint>
#include <string>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::os {

// Non-blocking, and given up by the system when the other side's machine has gone. Tries each
// address of the name in turn, until one answers, the deadline, or `cancel` (-1: nothing) is
// readable. The detail of the error: why not, without the host. Only the look-up of a name has no
// end but the system's.
Result<File> connect_tcp(const std::string& host, std::uint16_t port, Time deadline,
                         int cancel = -1);

}  // namespace tims::os
