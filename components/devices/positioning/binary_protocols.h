// Recognises the binary protocols of satellite receivers in a stream, so that a driver can state
// what it receives instead of NMEA.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace rack::device {

class BinaryProtocols {
 public:
  void add(std::span<const std::byte> bytes);
  // Name of the protocol and what to do; empty if none was recognised.
  [[nodiscard]] std::string_view found() const;

 private:
  static constexpr std::size_t kProtocols = 5;

  std::uint32_t last_ = 0;  // the last four bytes
  std::array<std::uint32_t, kProtocols> begun_{};
  std::array<std::uint32_t, kProtocols> ended_{};
};

}  // namespace rack::device
