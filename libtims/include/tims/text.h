// A short text inside a struct, in a fixed number of bytes: a name in a message, or in the router's
// tables, which do not allocate.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>

namespace tims {

// At most Bytes - 1 characters; always ends in NUL, and the bytes after it are zero. Original
// programs sometimes fill all bytes: decoding then drops the last character.
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
  // Truncated when it is too long: see assign().
  constexpr Text(std::string_view text) { (void)assign(text); }  // NOLINT

  // False: the text was truncated. It ends at the first NUL.
  constexpr bool assign(std::string_view text) {
    text = text.substr(0, text.find('\0'));
    const std::size_t size = std::min(text.size(), Bytes - 1);
    bytes_ = {};
    std::copy_n(text.begin(), size, bytes_.begin());
    return size == text.size();
  }

  [[nodiscard]] constexpr bool empty() const { return bytes_.front() == '\0'; }
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

}  // namespace tims
