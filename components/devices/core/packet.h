// Extracts UDP and TCP payloads from packet captures with Ethernet frames (also with VLAN tags),
// Linux cooked frames, loopback frames or bare IP packets. Fragments are put together.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "components/devices/core/datagram_assembly.h"

namespace rack::device {

// Numbers of LINKTYPE_ in packet captures.
enum class PacketLink : std::uint16_t {
  kNull = 0,  // loopback of BSD and macOS
  kEthernet = 1,
  kRawIp = 101,
  kLoop = 108,  // loopback of OpenBSD
  kLinuxCooked = 113,
  kIpv4 = 228,
  kIpv6 = 229,
  kLinuxCooked2 = 276,  // tcpdump -i any
};
// Empty if packets of this type cannot be read. `type`: a LINKTYPE_, or the number by which libpcap
// names it.
std::optional<PacketLink> packet_link(int type);

struct Payload {
  bool is_tcp = false;
  std::uint16_t from_port = 0;
  std::uint16_t to_port = 0;
  std::uint32_t sequence = 0;  // TCP: sequence number of the first byte
  std::span<const std::byte> bytes{};
};

class PacketReader {
 public:
  explicit PacketReader(PacketLink link) : link_(link) {}

  // The payload, valid until the next call. Empty for other protocols, truncated packets, and
  // fragments before the last one.
  std::optional<Payload> take(std::span<const std::byte> packet);

  // Numbers of packets without a payload.
  [[nodiscard]] std::uint64_t truncated() const { return truncated_; }
  [[nodiscard]] std::uint64_t incomplete() const { return assembly_.incomplete(); }

 private:
  PacketLink link_;
  DatagramAssembly assembly_;
  std::uint64_t truncated_ = 0;
};

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
