// Blocking sockets: at 100 ns per message a second system call for waiting would be significant.
#pragma once

#include <cstddef>
#include <span>

#include "os/file.h"
#include "tims/time.h"

namespace tims::bench {

void make_blocking(const os::File& socket);
// Sets the timeout of all reads; kForever: none.
void set_read_timeout(const os::File& socket, Duration timeout);

bool write_all(const os::File& socket, std::span<const std::byte> bytes);
bool read_exactly(const os::File& socket, std::span<std::byte> bytes);

}  // namespace tims::bench
