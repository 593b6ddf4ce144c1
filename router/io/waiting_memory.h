// Memory for messages that wait: reserved once, used by the system only as far as it is touched.
#pragma once

#include <cstddef>
#include <span>

#include "router/core/byte_chain.h"

namespace tims::io {

class WaitingMemory {
 public:
  // Less when the system does not give as much.
  explicit WaitingMemory(std::size_t bytes);
  WaitingMemory(const WaitingMemory&) = delete;
  WaitingMemory& operator=(const WaitingMemory&) = delete;
  ~WaitingMemory();

  core::BlockPool& pool() { return pool_; }
  [[nodiscard]] std::span<std::byte> bytes() const { return memory_; }

  // Bytes of such memory go back to the system; what they held is gone.
  static void discard(std::span<std::byte> bytes);

  // After every turn: once nothing waits any more, what it took goes back to the system.
  void give_back();

 private:
  std::span<std::byte> memory_;
  core::BlockPool pool_;
};

}  // namespace tims::io
