// Datagrams on their way out: several of one size to one address, which a path hands to the system
// in one call (UDP_SEGMENT).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "router/link/net_address.h"

namespace tims::link {

inline constexpr std::size_t kTrainBytesMax = 65'000;  // what the kernel takes in one call
inline constexpr std::size_t kTrainDatagramsMax = 64;

// What a datagram costs a link beside its bytes: Ethernet, IPv4 and UDP.
inline constexpr std::size_t kDatagramOverhead = 42;

struct Train {
  NetAddress to{};
  std::span<const std::byte> bytes{};  // all datagrams, one behind the other
  std::size_t datagram_size = 0;       // of each but the last, which may be shorter
  std::uint8_t dscp = 0;               // 6 bits, from the most urgent class in it
};

}  // namespace tims::link
