// A message on its way through the router.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "tims/message.h"
#include "tims/time.h"

namespace tims::core {

struct Message {
  Header header{};  // decoded
  // All of it, header included. The router writes the header here again when it forwards, so this
  // is memory that nobody else writes to: what lies in shared memory is copied out first.
  std::span<std::byte> bytes{};
  std::uint8_t hops = 0;  // links it has passed
  Duration waited{};      // in the queue of the last one, when it is traced

  [[nodiscard]] std::span<const std::byte> body() const { return bytes.subspan(kHeaderSize); }
};

}  // namespace tims::core
