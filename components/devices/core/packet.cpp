#include "components/devices/core/packet.h"

#include <algorithm>

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
  // Limits the rest to `count` bytes.
  void limit(std::size_t count) { bytes_ = bytes_.first(std::min(count, bytes_.size())); }

 private:
  std::span<const std::byte> bytes_;
  bool good_ = true;
};

std::uint32_t ether_type(PacketLink link, FieldReader& fields) {
  if (link == PacketLink::kRawIp) {
    const bool is_v6 = !fields.rest().empty() && (fields.rest().front() >> 4) == std::byte{6};
    return is_v6 ? kIpv6 : kIpv4;
  }
  constexpr std::size_t kAddresses = 12;
  constexpr std::size_t kCooked = 14;
  fields.skip(link == PacketLink::kLinuxCooked ? kCooked : kAddresses);
  std::uint32_t type = fields.take(2);
  while (fields.good() && (type == kVlan || type == kVlanOuter)) {
    fields.skip(2);
    type = fields.take(2);
  }
  return type;
}

// Advances to the payload of the IP packet; returns its protocol, 0 if the header is invalid.
std::uint32_t enter_ip(std::uint32_t type, FieldReader& fields) {
  if (type == kIpv4) {
    const std::uint32_t version_and_length = fields.take(1);
    const std::size_t header = (version_and_length & 0xF) * 4;
    fields.skip(1);
    const std::uint32_t total = fields.take(2);
    fields.skip(2);
    const std::uint32_t fragment = fields.take(2);
    fields.skip(1);
    const std::uint32_t protocol = fields.take(1);
    constexpr std::size_t kRead = 10;
    constexpr std::uint32_t kMoreOrOffset = 0x3FFF;
    if (header < 20 || total < header || (fragment & kMoreOrOffset) != 0) return 0;
    fields.skip(header - kRead);
    fields.limit(total - header);
    return protocol;
  }
  if (type != kIpv6) return 0;
  fields.skip(4);
  const std::uint32_t length = fields.take(2);
  const std::uint32_t protocol = fields.take(1);
  fields.skip(1 + 2 * 16);
  fields.limit(length);
  return protocol;
}

}  // namespace

std::optional<Payload> payload_of(PacketLink link, std::span<const std::byte> packet) {
  FieldReader fields(packet);
  const std::uint32_t type = ether_type(link, fields);
  const std::uint32_t protocol = enter_ip(type, fields);
  if (protocol != kTcp && protocol != kUdp) return std::nullopt;
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
