// Extracts UDP and TCP payloads from packet captures with Ethernet frames (also with VLAN tags),
// Linux cooked frames or bare IP packets.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>

namespace rack::device {

// Numbers of LINKTYPE_ in packet captures.
enum class PacketLink : std::uint16_t { kEthernet = 1, kRawIp = 101, kLinuxCooked = 113 };

struct Payload {
  bool is_tcp = false;
  std::uint16_t from_port = 0;
  std::uint16_t to_port = 0;
  std::uint32_t sequence = 0;  // TCP: sequence number of the first byte
  std::span<const std::byte> bytes{};
};

// Empty for other protocols, fragments and truncated packets.
std::optional<Payload> payload_of(PacketLink link, std::span<const std::byte> packet);

// TCP streams without duplicates: bytes that were captured twice or retransmitted are removed.
// Missing bytes are skipped.
class StreamOrder {
 public:
  // Returns the part of the payload that was not returned before.
  std::span<const std::byte> take(const Payload& payload);

 private:
  std::map<std::uint32_t, std::uint32_t> next_;  // next sequence number; key: both ports
};

}  // namespace rack::device
