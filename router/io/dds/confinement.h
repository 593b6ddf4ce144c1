// Takes away from the calling process, for good, what a DDS helper does not need: new privileges,
// the files of this host, other programs and processes, and all sockets but those of IP. What an
// attacker gains by a fault in the library is then a process that can send datagrams of this host.
#pragma once

#include <span>
#include <string>

#include "tims/result.h"

namespace tims::io {

// `readable`: files that stay readable, beside libraries and what they read. Call it before there
// are other threads. An error names what the kernel does not support; then nothing, or a part, is
// in force.
Result<void> confine(std::span<const std::string> readable);

}  // namespace tims::io
