// A short text inside a struct: no allocation, cut when it is too long.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tims::core {

template <std::size_t capacity>
class Text {
  static_assert(capacity < 256);

 public:
  constexpr Text() = default;
  constexpr Text(std::string_view text)  // NOLINT(google-explicit-constructor)
      : size_(static_cast<std::uint8_t>(std::min(text.size(), capacity))) {
    std::copy_n(text.begin(), size_, chars_.begin());
  }

  [[nodiscard]] constexpr std::string_view view() const { return {chars_.data(), size_}; }
  [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
  constexpr bool operator==(const Text& other) const { return view() == other.view(); }

 private:
  std::array<char, capacity> chars_{};
  std::uint8_t size_ = 0;
};

}  // namespace tims::core
