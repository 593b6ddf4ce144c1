// What a packet capture has recorded of a device: the payload of UDP and TCP, taken out of frames
// of Ethernet (also with VLAN tags), Linux cooked captures, and bare IP.
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
  std::uint32_t sequence = 0;  // of tcp: of the first byte
  std::span<const std::byte> bytes{};
};

// Nothing: something else, a part of a datagram, or cut off.
std::optional<Payload> payload_of(PacketLink link, std::span<const std::byte> packet);

// Streams in which each byte comes once, although packets are captured twice or sent again. What is
// missing is missing.
class StreamOrder {
 public:
  // What of it is new.
  std::span<const std::byte> take(const Payload& payload);

 private:
  std::map<std::uint32_t, std::uint32_t> next_;  // sequence numbers by both ports
};

}  // namespace rack::device
