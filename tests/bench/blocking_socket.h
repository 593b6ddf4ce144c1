// Sockets whose calls wait: at 100 ns a message a second system call to wait would be seen.
#pragma once

#include <cstddef>
#include <span>

#include "os/file.h"
#include "tims/time.h"

namespace tims::bench {

void make_blocking(const os::File& socket);
// Of every read from now on; kForever: none.
void set_read_timeout(const os::File& socket, Duration timeout);

bool write_all(const os::File& socket, std::span<const std::byte> bytes);
bool read_exactly(const os::File& socket, std::span<std::byte> bytes);

}  // namespace tims::bench
