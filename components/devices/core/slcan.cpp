#include "components/devices/core/slcan.h"

#include <algorithm>

namespace rack::device::slcan {
namespace {

constexpr std::uint32_t kExtended = 0x80000000;
constexpr std::uint32_t kRemote = 0x40000000;
constexpr std::uint32_t kStandardMask = 0x7FF;
constexpr std::uint32_t kExtendedMask = 0x1FFFFFFF;
constexpr std::size_t kStandardDigits = 3;
constexpr std::size_t kExtendedDigits = 8;
constexpr std::array<std::uint32_t, 9> kRates = {10000,  20000,  50000,  100000, 125000,
                                                 250000, 500000, 800000, 1000000};

std::optional<std::uint32_t> hex(std::string_view digits) {
  std::uint32_t value = 0;
  for (const char c : digits) {
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                             : -1;
    if (digit < 0) return {};
    value = value << 4 | static_cast<std::uint32_t>(digit);
  }
  return value;
}

void append_hex(std::string& text, std::uint32_t value, std::size_t digits) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  for (std::size_t i = digits; i-- > 0;) text += kDigits[value >> 4 * i & 0xF];
}

}  // namespace

std::optional<Frame> parse(std::string_view line) {
  if (line.empty() || std::string_view("tTrR").find(line[0]) == std::string_view::npos) return {};
  const bool is_extended = line[0] == 'T' || line[0] == 'R';
  const bool is_remote = line[0] == 'r' || line[0] == 'R';
  const std::size_t digits = is_extended ? kExtendedDigits : kStandardDigits;
  if (line.size() < digits + 2) return {};
  const auto id = hex(line.substr(1, digits));
  const auto size = hex(line.substr(1 + digits, 1));
  if (!id || !size || *size > 8 || *id > (is_extended ? kExtendedMask : kStandardMask)) return {};
  Frame frame{.id = *id | (is_extended ? kExtended : 0) | (is_remote ? kRemote : 0),
              .size = is_remote ? 0 : *size};
  const std::string_view data = line.substr(digits + 2);
  // Some adapters append a time stamp to the bytes.
  constexpr std::size_t kTime = 4;
  if (data.size() != 2 * frame.size && data.size() != 2 * frame.size + kTime) return {};
  for (std::size_t i = 0; i < frame.size; ++i) {
    const auto byte = hex(data.substr(2 * i, 2));
    if (!byte) return {};
    frame.bytes[i] = static_cast<std::byte>(*byte);
  }
  return frame;
}

void append(std::string& text, std::uint32_t id, std::span<const std::byte> bytes) {
  const bool is_extended = (id & kExtended) != 0;
  const bool is_remote = (id & kRemote) != 0;
  text += is_remote ? (is_extended ? 'R' : 'r') : (is_extended ? 'T' : 't');
  append_hex(text, id & (is_extended ? kExtendedMask : kStandardMask),
             is_extended ? kExtendedDigits : kStandardDigits);
  append_hex(text, static_cast<std::uint32_t>(bytes.size()), 1);
  if (!is_remote)
    for (const std::byte byte : bytes) append_hex(text, std::to_integer<std::uint32_t>(byte), 2);
  text += '\r';
}

std::optional<std::string> opening(std::uint32_t bit_rate) {
  const auto* const found = std::ranges::find(kRates, bit_rate);
  if (found == kRates.end()) return {};
  return "C\rS" + std::to_string(found - kRates.begin()) + "\rO\r";
}

}  // namespace rack::device::slcan
