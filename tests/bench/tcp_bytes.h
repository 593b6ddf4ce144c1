// Bytes to and from blocking sockets, and the bytes with which a client of the original registers.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "libtims/os/file.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::bench {

void make_blocking(const os::File& socket);
void set_read_timeout(const os::File& socket, Duration timeout);

bool write_all(const os::File& socket, std::span<const std::byte> bytes);
// Header and body in one system call.
bool write_both(const os::File& socket, std::span<const std::byte> first,
                std::span<const std::byte> second);
bool read_exactly(const os::File& socket, std::span<std::byte> bytes);

inline constexpr std::size_t kInitBytes = kHeaderSize + 4;
// A command that registers `address` and is answered.
std::array<std::byte, kInitBytes> init_of(Address address);
// What a client says first: no watchdog, please; then the above.
std::array<std::byte, kHeaderSize + kInitBytes> registration_of(Address address);

}  // namespace tims::bench
