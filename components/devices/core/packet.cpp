#include "components/devices/core/packet.h"

#include <algorithm>
#include <array>

namespace rack::device {
namespace {

constexpr std::uint16_t kIpv4 = 0x0800;
constexpr std::uint16_t kIpv6 = 0x86DD;
constexpr std::uint16_t kVlan = 0x8100;
constexpr std::uint16_t kVlanOuter = 0x88A8;
constexpr std::uint8_t kTcp = 6;
constexpr std::uint8_t kUdp = 17;

// Reads big-endian numbers from the front; a read past the end of the packet returns nothing.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] std::span<const std::byte> rest() const { return bytes_; }
  std::uint32_t take(std::size_t count) {
    std::uint32_t value = 0;
    if (count > bytes_.size()) good_ = false;
    for (std::size_t i = 0; good_ && i < count; ++i)
      value = value << 8 | std::to_integer<std::uint32_t>(bytes_[i]);
    skip(count);
    return value;
  }
  void skip(std::size_t count) {
    if (count > bytes_.size()) good_ = false;
    bytes_ = bytes_.subspan(std::min(count, bytes_.size()));
  }
  // Limits the rest to `count` bytes. Fewer bytes mean that the capture was truncated.
  void limit(std::size_t count) {
    if (count > bytes_.size()) good_ = false;
    bytes_ = bytes_.first(std::min(count, bytes_.size()));
  }

 private:
  std::span<const std::byte> bytes_;
  bool good_ = true;
};

// Advances to the IP packet; returns its protocol of Ethernet.
std::uint32_t ether_type(PacketLink link, FieldReader& fields) {
  constexpr std::size_t kEthernetAddresses = 12;
  constexpr std::size_t kCookedFields = 14;
  constexpr std::size_t kCooked2Fields = 18;
  constexpr std::size_t kFamily = 4;
  std::uint32_t type = 0;
  switch (link) {
    case PacketLink::kEthernet:
    case PacketLink::kLinuxCooked:
      fields.skip(link == PacketLink::kEthernet ? kEthernetAddresses : kCookedFields);
      type = fields.take(2);
      break;
    case PacketLink::kLinuxCooked2:
      type = fields.take(2);
      fields.skip(kCooked2Fields);
      break;
    case PacketLink::kNull:
    case PacketLink::kLoop:
      // The number of the address family differs between systems; the IP version does not.
      fields.skip(kFamily);
      [[fallthrough]];
    case PacketLink::kRawIp:
    case PacketLink::kIpv4:
    case PacketLink::kIpv6: {
      const auto first = fields.rest().empty() ? 0U : std::to_integer<unsigned>(fields.rest()[0]);
      return first >> 4 == 4 ? kIpv4 : first >> 4 == 6 ? kIpv6 : 0;
    }
  }
  while (fields.good() && (type == kVlan || type == kVlanOuter)) {
    fields.skip(2);
    type = fields.take(2);
  }
  return type;
}

// What the header of an IP packet states. The payload is what remains in the FieldReader.
struct IpHeader {
  std::uint32_t protocol = 0;  // 0: not a valid IP packet
  bool is_fragment = false;
  DatagramAssembly::Fragment fragment{};
};

void take_addresses(FieldReader& fields, std::size_t size, DatagramAssembly::Key& key) {
  const auto addresses = fields.rest().first(std::min(2 * size, fields.rest().size()));
  std::ranges::copy(addresses, key.addresses.begin());
  fields.skip(2 * size);
}

IpHeader enter_ipv4(FieldReader& fields) {
  constexpr std::uint32_t kMore = 0x2000;
  constexpr std::uint32_t kOffset = 0x1FFF;
  constexpr std::size_t kLeast = 20;
  IpHeader ip;
  const std::size_t header = (fields.take(1) & 0xF) * 4;
  fields.skip(1);
  const std::size_t total = fields.take(2);
  ip.fragment.key.id = fields.take(2);
  const std::uint32_t flags = fields.take(2);
  fields.skip(1);
  const std::uint32_t protocol = fields.take(1);
  fields.skip(2);
  take_addresses(fields, 4, ip.fragment.key);
  // A network card that splits segments itself leaves the total length 0.
  if (!fields.good() || header < kLeast || (total != 0 && total < header)) return {};
  fields.skip(header - kLeast);
  if (total != 0) fields.limit(total - header);
  ip.protocol = ip.fragment.key.protocol = protocol;
  ip.is_fragment = (flags & (kMore | kOffset)) != 0;
  ip.fragment.offset = std::size_t{flags & kOffset} * 8;
  ip.fragment.is_last = (flags & kMore) == 0;
  return ip;
}

IpHeader enter_ipv6(FieldReader& fields) {
  constexpr std::uint32_t kHopByHop = 0;
  constexpr std::uint32_t kRouting = 43;
  constexpr std::uint32_t kFragment = 44;
  constexpr std::uint32_t kDestination = 60;
  IpHeader ip;
  fields.skip(4);
  const std::size_t length = fields.take(2);
  std::uint32_t next = fields.take(1);
  fields.skip(1);
  take_addresses(fields, 16, ip.fragment.key);
  if (length != 0) fields.limit(length);
  while (fields.good() && (next == kHopByHop || next == kRouting || next == kDestination)) {
    next = fields.take(1);
    const std::size_t more = fields.take(1);
    fields.skip(6 + 8 * more);
  }
  if (next == kFragment) {
    next = fields.take(1);
    fields.skip(1);
    const std::uint32_t place = fields.take(2);
    ip.fragment.key.id = fields.take(4);
    ip.fragment.offset = place & 0xFFF8U;
    ip.fragment.is_last = (place & 1U) == 0;
    ip.is_fragment = true;
  }
  if (fields.good()) ip.protocol = ip.fragment.key.protocol = next;
  return ip;
}

IpHeader enter_ip(std::uint32_t type, FieldReader& fields) {
  if (type == kIpv4) return enter_ipv4(fields);
  if (type == kIpv6) return enter_ipv6(fields);
  return {};
}

// The payload of a whole datagram.
std::optional<Payload> payload_of(std::uint32_t protocol, FieldReader& fields) {
  Payload payload{.is_tcp = protocol == kTcp,
                  .from_port = static_cast<std::uint16_t>(fields.take(2)),
                  .to_port = static_cast<std::uint16_t>(fields.take(2))};
  if (payload.is_tcp) {
    payload.sequence = fields.take(4);
    fields.skip(4);
    const std::size_t header = (fields.take(1) >> 4) * 4;
    constexpr std::size_t kRead = 13;
    if (header < 20) return std::nullopt;
    fields.skip(header - kRead);
  } else {
    const std::uint32_t length = fields.take(2);
    fields.skip(2);
    constexpr std::uint32_t kHeader = 8;
    if (length < kHeader) return std::nullopt;
    fields.limit(length - kHeader);
  }
  if (!fields.good()) return std::nullopt;
  payload.bytes = fields.rest();
  return payload;
}

}  // namespace

std::optional<PacketLink> packet_link(int type) {
  constexpr std::array kLinks = {PacketLink::kNull, PacketLink::kEthernet,    PacketLink::kRawIp,
                                 PacketLink::kLoop, PacketLink::kLinuxCooked, PacketLink::kIpv4,
                                 PacketLink::kIpv6, PacketLink::kLinuxCooked2};
  // libpcap has other numbers for bare IP packets than files have, which depend on the system.
  constexpr std::array kRawNumbers = {12, 14};
  if (std::ranges::find(kRawNumbers, type) != kRawNumbers.end()) return PacketLink::kRawIp;
  for (const PacketLink link : kLinks)
    if (static_cast<int>(link) == type) return link;
  return std::nullopt;
}

std::optional<Payload> PacketReader::take(std::span<const std::byte> packet) {
  FieldReader fields(packet);
  const std::uint32_t type = ether_type(link_, fields);
  IpHeader ip = enter_ip(type, fields);
  const bool is_ip = type == kIpv4 || type == kIpv6;
  if (!fields.good()) {
    truncated_ += is_ip ? 1 : 0;
    return std::nullopt;
  }
  if (ip.protocol != kTcp && ip.protocol != kUdp) return std::nullopt;
  std::optional<Payload> payload;
  if (ip.is_fragment) {
    ip.fragment.bytes = fields.rest();
    const auto datagram = assembly_.add(ip.fragment);
    if (!datagram) return std::nullopt;
    FieldReader whole(*datagram);
    payload = payload_of(ip.protocol, whole);
  } else {
    payload = payload_of(ip.protocol, fields);
  }
  if (!payload) ++truncated_;
  return payload;
}

std::span<const std::byte> StreamOrder::take(const Payload& payload) {
  const std::uint32_t stream = std::uint32_t{payload.from_port} << 16 | payload.to_port;
  const auto size = static_cast<std::uint32_t>(payload.bytes.size());
  const auto [known, is_new] = next_.try_emplace(stream, payload.sequence + size);
  if (is_new || size == 0) return payload.bytes;
  // Bytes of this payload that were returned before. A sequence number far away belongs to a new
  // connection.
  constexpr std::int32_t kFar = 1 << 20;
  const auto old = static_cast<std::int32_t>(known->second - payload.sequence);
  if (old > 0 && old < kFar) {
    const auto seen = std::min(static_cast<std::uint32_t>(old), size);
    known->second += size - seen;
    return payload.bytes.subspan(seen);
  }
  known->second = payload.sequence + size;
  return payload.bytes;
}

}  // namespace rack::device
