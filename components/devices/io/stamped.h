// Datagrams and CAN frames with the time at which the kernel, or the interface itself, took them:
// not when we got round to reading.
#pragma once

#include <cstddef>
#include <span>

#include <sys/socket.h>

#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

struct Stamped {
  bool is_there = false;  // false: nothing waits now
  std::size_t size = 0;
  tims::Time when{};
  std::uint32_t dropped = 0;  // by the kernel since the socket is open, because nobody read
};

void ask_for_stamps(int socket);
tims::Result<Stamped> receive_stamped(int socket, std::span<std::byte> bytes, sockaddr* from,
                                      socklen_t& from_size);

}  // namespace rack::device
