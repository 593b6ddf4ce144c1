// SLCAN: CAN frames as text, the protocol of serial USB adapters (Lawicel CAN232, CANable,
// CANtact). "t1234DEADBEEF" and a carriage return is a frame with identifier 0x123 and four bytes.
// T has a 29 bit identifier; r and R are remote frames. "S6" sets the bit rate, "O" opens the bus,
// "C" closes it. The adapter answers 0D for success and 07 for an error.
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

// `line` is without the carriage return. Empty if the line is not a frame.
std::optional<Frame> parse(std::string_view line);
// Appends the frame with its carriage return.
void append(std::string& text, std::uint32_t id, std::span<const std::byte> bytes);

// The commands that close, configure and open an adapter. Empty if SLCAN has no such bit rate.
std::optional<std::string> opening(std::uint32_t bit_rate);

}  // namespace rack::device::slcan
