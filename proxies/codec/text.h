// A text in a fixed number of bytes of a message, such as a file name.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>

namespace rack {

// At most Bytes - 1 characters; always ends in NUL, and what follows is zero. Programs of the
// original fill all bytes at times: reading cuts the last character then.
template <std::size_t Bytes>
class Text {
 public:
  static constexpr std::size_t kBytes = Bytes;

  constexpr Text() = default;
  template <std::size_t N>
  constexpr Text(const char (&literal)[N]) {  // NOLINT(google-explicit-constructor)
    static_assert(N <= Bytes, "too long for this field");
    (void)assign(literal);
  }

  // False: only the beginning fitted. Ends at the first NUL.
  constexpr bool assign(std::string_view text) {
    text = text.substr(0, text.find('\0'));
    const std::size_t size = std::min(text.size(), Bytes - 1);
    bytes_ = {};
    std::copy_n(text.begin(), size, bytes_.begin());
    return size == text.size();
  }

  [[nodiscard]] constexpr std::string_view view() const { return bytes_.data(); }
  constexpr operator std::string_view() const { return view(); }  // NOLINT
  [[nodiscard]] constexpr const std::array<char, Bytes>& bytes() const { return bytes_; }
  template <std::convertible_to<std::string_view> Other>
  friend constexpr bool operator==(const Text& a, const Other& b) {
    return a.view() == std::string_view(b);
  }
  bool operator==(const Text&) const = default;

 private:
  std::array<char, Bytes> bytes_{};
};

}  // namespace rack
