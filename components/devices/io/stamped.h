// Receives datagrams and CAN frames with the time stamp of the kernel or of the interface, which is
// more exact than the time of reading.
#pragma once

#include <cstddef>
#include <span>

#include <sys/socket.h>

#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

struct Stamped {
  bool is_there = false;  // false: nothing to receive now
  std::size_t size = 0;
  tims::Time when{};
  std::uint32_t dropped = 0;  // total dropped by the kernel because its buffer was full
};

void ask_for_stamps(int socket);
tims::Result<Stamped> receive_stamped(int socket, std::span<std::byte> bytes, sockaddr* from,
                                      socklen_t& from_size);

}  // namespace rack::device
