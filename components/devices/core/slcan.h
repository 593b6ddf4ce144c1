// CAN frames as text, as USB adapters with a serial line speak it (Lawicel CAN232, CANable,
// CANtact): "t1234DEADBEEF" and a carriage return is a frame of identifier 123 with four bytes; T
// has 29 bits, r and R ask for a frame. "S6" is the bit rate, "O" opens the bus, "C" closes it; 0D
// is yes, 07 no.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rack::device::slcan {

struct Frame {
  std::uint32_t id = 0;  // with the flags of SocketCAN
  std::array<std::byte, 8> bytes{};
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::byte> view() const { return std::span(bytes).first(size); }
};

// Without the carriage return. Nothing: it is no frame.
std::optional<Frame> parse(std::string_view line);
// With the carriage return.
void append(std::string& text, std::uint32_t id, std::span<const std::byte> bytes);

// What closes, sets and opens an adapter. Nothing: no adapter has this bit rate.
std::optional<std::string> opening(std::uint32_t bit_rate);

}  // namespace rack::device::slcan
