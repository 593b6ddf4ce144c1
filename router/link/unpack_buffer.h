// Room for decompressed messages, which are read until the turn ends: one after the other in few
// places of the message memory, since thousands of small ones may arrive in one turn.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "router/link/buffers.h"

namespace tims::link {

class UnpackBuffer {
 public:
  // `done`: places that are full, until nobody reads them any more.
  UnpackBuffer(MessageMemory& memory, std::vector<MessageBuffer>& done)
      : memory_(memory), done_(done) {}

  // True when take(size) succeeds now. `size`: at most that of the largest message.
  [[nodiscard]] bool reserve(std::size_t size);
  // Empty when there is no memory now.
  [[nodiscard]] std::span<std::byte> take(std::size_t size);
  // Nobody reads what was taken any more.
  void release() {
    open_.reset();
    used_ = 0;
  }

 private:
  MessageMemory& memory_;
  std::vector<MessageBuffer>& done_;
  MessageBuffer open_;    // with room for further messages
  std::size_t used_ = 0;  // of its bytes
};

}  // namespace tims::link
