#include "components/devices/chassis/mavlink.h"

#include <algorithm>
#include <bit>

namespace rack::device::mavlink {
namespace {

constexpr std::byte kVersion1{0xFE};
constexpr std::byte kVersion2{0xFD};
constexpr std::size_t kHead1 = 6;
constexpr std::size_t kHead2 = 10;
constexpr std::size_t kCrc = 2;
constexpr std::size_t kSignature = 13;
constexpr unsigned kSigned = 0x01;  // incompatibility flag: the packet is signed

// CRC X.25, reflected, four bytes at once: table n is for a byte followed by n zero bytes.
constexpr auto kTables = [] {
  constexpr unsigned kPolynomial = 0x8408;
  std::array<std::array<std::uint16_t, 256>, 4> tables{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned sum = byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? sum >> 1 ^ kPolynomial : sum >> 1;
    tables[0][byte] = static_cast<std::uint16_t>(sum);
  }
  for (std::size_t n = 1; n < tables.size(); ++n)
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const unsigned before = tables[n - 1][byte];
      tables[n][byte] = static_cast<std::uint16_t>(before >> 8 ^ tables[0][before & 0xFF]);
    }
  return tables;
}();

}  // namespace

std::optional<Layout> layout_of(std::uint32_t message) {
  switch (static_cast<Message>(message)) {
    case Message::kHeartbeat:
      return Layout{9, 50};
    case Message::kSystemStatus:
      return Layout{31, 124};
    case Message::kGpsRaw:
      return Layout{30, 24};
    case Message::kAttitude:
      return Layout{28, 39};
    case Message::kLocalPosition:
      return Layout{28, 185};
    case Message::kCommand:
      return Layout{33, 152};
    case Message::kCommandAck:
      return Layout{3, 143};
    case Message::kSetPositionTarget:
      return Layout{53, 143};
    case Message::kOdometry:
      return Layout{230, 91};
  }
  return {};
}

std::uint16_t crc(std::span<const std::byte> bytes, std::uint8_t extra) {
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  unsigned sum = 0xFFFF;
  std::size_t i = 0;
  for (; i + 4 <= bytes.size(); i += 4) {
    const unsigned mixed = sum ^ (at(i) | at(i + 1) << 8);
    sum = static_cast<unsigned>(kTables[3][mixed & 0xFF] ^ kTables[2][mixed >> 8] ^
                                kTables[1][at(i + 2)] ^ kTables[0][at(i + 3)]);
  }
  const auto add = [&](unsigned byte) { sum = sum >> 8 ^ kTables[0][(sum ^ byte) & 0xFF]; };
  for (; i < bytes.size(); ++i) add(at(i));
  add(extra);
  return static_cast<std::uint16_t>(sum);
}

double Packet::real(std::size_t at) const {
  return static_cast<double>(std::bit_cast<float>(number<std::uint32_t>(at)));
}

bool Packets::next(Packet& packet) {
  while (buffer_.size() >= kHead1) {
    const auto bytes = buffer_.bytes();
    const bool is_new = bytes[0] == kVersion2;
    if (!is_new && bytes[0] != kVersion1) {
      buffer_.consume(1);
      continue;
    }
    const std::size_t head = is_new ? kHead2 : kHead1;
    if (bytes.size() < head) return false;
    const auto flags = is_new ? std::to_integer<unsigned>(bytes[2]) : 0U;
    const std::size_t length = std::to_integer<std::size_t>(bytes[1]);
    const std::size_t size =
        head + length + kCrc + ((flags & kSigned) != 0 ? kSignature : std::size_t{0});
    const std::uint32_t message = is_new ? little_endian<std::uint32_t>(bytes, 7 - 1) >> 8
                                         : std::to_integer<std::uint32_t>(bytes[5]);
    const auto layout = layout_of(message);
    if ((flags & ~kSigned) != 0) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < size) return false;
    // The CRC of a message with an unknown layout cannot be verified; autopilots send many of them.
    if (!layout) {
      buffer_.consume(size);
      continue;
    }
    if (crc(bytes.subspan(1, head - 1 + length), layout->crc_extra) !=
        little_endian<std::uint16_t>(bytes, head + length)) {
      ++broken_;
      buffer_.consume(1);
      continue;
    }
    packet.message = static_cast<Message>(message);
    packet.system = std::to_integer<std::uint8_t>(bytes[is_new ? 5 : 3]);
    packet.component = std::to_integer<std::uint8_t>(bytes[is_new ? 6 : 4]);
    const auto rest = std::ranges::copy(bytes.subspan(head, length), packet.payload.begin()).out;
    if (length < layout->size) std::fill(rest, packet.payload.begin() + layout->size, std::byte{0});
    packet.began = buffer_.time_of(0);
    buffer_.consume(size);
    return true;
  }
  return false;
}

Writer::Writer(Message message, std::uint8_t sequence, std::uint8_t system,
               std::uint8_t component) {
  const auto number = static_cast<std::uint32_t>(message);
  extra_ = layout_of(number).value_or(Layout{}).crc_extra;
  bytes_[0] = kVersion2;
  bytes_[4] = static_cast<std::byte>(sequence);
  bytes_[5] = static_cast<std::byte>(system);
  bytes_[6] = static_cast<std::byte>(component);
  for (std::size_t i = 0; i < 3; ++i) bytes_[7 + i] = static_cast<std::byte>(number >> 8 * i);
}

Writer& Writer::put_real(double value) {
  return put(std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

std::span<const std::byte> Writer::finish() {
  while (size_ > kHead2 + 1 && bytes_[size_ - 1] == std::byte{0}) --size_;
  bytes_[1] = static_cast<std::byte>(size_ - kHead2);
  const std::uint16_t sum = crc(std::span(bytes_).subspan(1, size_ - 1), extra_);
  return put(sum), std::span(bytes_).first(size_);
}

}  // namespace rack::device::mavlink
