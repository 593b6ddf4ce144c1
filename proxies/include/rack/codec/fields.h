// The parts of a message whose length differs from message to message.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <vector>

namespace rack {

// In a message struct, the number (i32) of elements of the sequence that follows it, right behind
// or some fields later. It holds nothing: the sequence knows its size.
//
//   struct LadarData {
//     ...
//     Count pointNum;
//     Sequence<LadarPoint, 2160> points;
//   };
struct Count {
  bool operator==(const Count&) const = default;
};

// At most Max elements when encoded or decoded; in between it is a vector. A sequence that was
// reserved once never allocates again, also not when a message is decoded into it.
template <typename T, std::size_t Max>
struct Sequence : std::vector<T> {
  using Element = T;
  static constexpr std::size_t kMax = Max;

  using std::vector<T>::vector;
  void reserve_all() { this->reserve(Max); }
};

// A sequence whose length follows from other fields, such as the pixels of an image. Its struct
// says so in a member function, one length a tail in their order, negative for what cannot be:
//
//   [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const { return {width * height}; }
template <typename T, std::size_t Max>
struct Tail : std::vector<T> {
  using Element = T;
  static constexpr std::size_t kMax = Max;

  using std::vector<T>::vector;
  void reserve_all() { this->reserve(Max); }
};

// --- A text in a fixed number of bytes of a message, such as a file name.

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
