#include "router/link/transport.h"

#include <algorithm>
#include <charconv>

#include "base/text.h"

namespace tims::link {
namespace {

constexpr std::array<std::uint8_t, 12> kV4Prefix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

std::string v4_text(const std::array<std::uint8_t, 16>& ip) {
  std::string text;
  for (std::size_t i = 12; i < 16; ++i)
    text.append(i > 12 ? "." : "").append(std::to_string(ip[i]));
  return text;
}

std::string hex(unsigned value) {
  std::array<char, 4> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, 16);
  return {digits.data(), end.ptr};
}

// RFC 5952: the longest run of zero groups is "::".
std::string v6_text(const std::array<std::uint8_t, 16>& ip) {
  std::array<unsigned, 8> groups{};
  for (std::size_t i = 0; i < 8; ++i) groups[i] = unsigned{ip[2 * i]} << 8 | ip[2 * i + 1];
  std::size_t best = 8;
  std::size_t longest = 1;
  for (std::size_t i = 0; i < 8; ++i) {
    std::size_t n = 0;
    while (i + n < 8 && groups[i + n] == 0) ++n;
    if (n > longest) best = i, longest = n;
  }
  std::string text;
  for (std::size_t i = 0; i < 8; ++i) {
    if (i == best) {
      text += "::";
      i += longest - 1;
      continue;
    }
    if (!text.empty() && text.back() != ':') text += ':';
    text += hex(groups[i]);
  }
  return text;
}

constexpr std::size_t kPaddingMax = 3;

}  // namespace

bool NetAddress::is_v4() const {
  return std::equal(kV4Prefix.begin(), kV4Prefix.end(), ip.begin());
}

std::string NetAddress::to_string() const {
  if (kind == PathKind::kDds) {
    const DdsParticipant bytes = participant();
    return "dds:" + base::to_hex(std::as_bytes(std::span(bytes)));
  }
  const std::string number = ":" + std::to_string(port);
  const std::string protocol = kind == PathKind::kTcp ? "tcp:" : "";
  if (is_v4()) return protocol + v4_text(ip) + number;
  const std::string zone = scope == 0 ? "" : "%" + std::to_string(scope);
  return protocol + "[" + v6_text(ip) + zone + "]" + number;
}

NetAddress NetAddress::v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d,
                          std::uint16_t port) {
  NetAddress address{.port = port};
  std::ranges::copy(kV4Prefix, address.ip.begin());
  address.ip[12] = a;
  address.ip[13] = b;
  address.ip[14] = c;
  address.ip[15] = d;
  return address;
}

DdsParticipant NetAddress::participant() const {
  DdsParticipant participant{};
  std::copy_n(ip.begin(), participant.size(), participant.begin());
  return participant;
}

NetAddress NetAddress::dds(const DdsParticipant& participant) {
  NetAddress address{.port = 1, .kind = PathKind::kDds};  // DDS addresses share one port
  std::ranges::copy(participant, address.ip.begin());
  return address;
}

bool Batch::valid() const {
  std::span<const std::byte> rest = bytes_;
  while (rest.size() >= kBatchSizeBytes && size_at(rest, 0) != 0) {
    const std::size_t whole = kBatchSizeBytes + size_at(rest, 0);
    if (whole > rest.size()) return false;
    rest = rest.subspan(whole);
  }
  const auto is_zero = [](std::byte byte) { return byte == std::byte{}; };
  return rest.size() < bytes_.size() && rest.size() <= kPaddingMax &&
         std::ranges::all_of(rest, is_zero);
}

}  // namespace tims::link
