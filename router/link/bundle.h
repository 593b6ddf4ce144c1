// Several datagrams as one sample of a DDS topic: each behind its size, two bytes. So many small
// ones cost what one costs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tims::link {

inline constexpr std::size_t kBundleSizeBytes = 2;  // before each datagram
inline constexpr std::size_t kBundledMax = 0xFFFF;  // bytes of one datagram

// Bytes that somebody else wrote: valid() looks at all of them, first.
class Bundle {
 public:
  explicit Bundle(std::span<std::byte> bytes) : bytes_(bytes) {}

  // At least one datagram, none of them empty, and nothing behind the last one but the zeros that
  // make a sample a multiple of four bytes.
  [[nodiscard]] bool valid() const;

  // visit(std::span<std::byte> datagram), of a valid one.
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t at = 0; at + kBundleSizeBytes <= bytes_.size();) {
      const std::size_t size = size_at(bytes_, at);
      if (size == 0) return;
      visit(bytes_.subspan(at + kBundleSizeBytes, size));
      at += kBundleSizeBytes + size;
    }
  }

  static std::size_t size_at(std::span<const std::byte> bytes, std::size_t at) {
    return std::to_integer<std::size_t>(bytes[at]) | std::to_integer<std::size_t>(bytes[at + 1])
                                                         << 8;
  }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace tims::link
