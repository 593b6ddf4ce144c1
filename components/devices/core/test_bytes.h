// For tests of decoders: bytes from text, recorded files, and an Output that stores sent bytes.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "rack/devices/dialogue.h"

namespace rack::device {

inline std::vector<std::byte> bytes_of_text(std::string_view text) {
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

inline std::vector<std::byte> bytes_of_hex(std::string_view hex) {
  return tims::base::parse_hex(hex).value_or(std::vector<std::byte>{});
}

// Reads a file of tests/data/devices.
inline std::vector<std::byte> bytes_of_file(const std::string& name) {
  std::ifstream file(std::filesystem::path(DEVICE_DATA) / name, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  return bytes_of_text(text);
}

class ReceivedOutput : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t = 0) override {
    sent.emplace_back(bytes.begin(), bytes.end());
  }
  void set_baud(std::uint32_t rate) override { baud = rate; }

  std::vector<std::vector<std::byte>> sent;
  std::uint32_t baud = 0;
};

}  // namespace rack::device
