// Bodies of messages for tests: one that compresses well, and one that does not compress.
#pragma once

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

namespace tims::compression {

// Structs of 16 bytes of which one byte varies, by four bits, as the points of a scan do.
inline std::vector<std::byte> scan_like(std::size_t size, unsigned seed = 0) {
  std::vector<std::byte> bytes(size);
  std::minstd_rand random(seed + 1);
  for (std::size_t i = 0; i < size; ++i)
    bytes[i] = static_cast<std::byte>(i % 16 == 4 ? random() >> 8 & 15 : i % 16 * 5);
  return bytes;
}

inline std::vector<std::byte> noise(std::size_t size) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(size);
  std::ranges::generate(bytes, [&] { return static_cast<std::byte>(random()); });
  return bytes;
}

}  // namespace tims::compression
