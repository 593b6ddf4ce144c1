// How far the other side of a TCP connection has come.
#pragma once

#include <cstdint>

namespace tims::io {

// Bytes that its system has acknowledged, since the connection began. Once that system holds as
// much as it will, this grows only as fast as the program there reads.
std::uint64_t bytes_acknowledged(int socket);

}  // namespace tims::io
