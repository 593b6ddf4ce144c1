// Short texts without allocation: those inside a struct (Text), and those of closed lists (Label).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tims::core {

// A short text inside a struct: no allocation, cut when it is too long.
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

// Closed lists: an enum, and for each of its values one word for JSON and metrics and one sentence
// for people. A list that misses a value, or has two of them in the wrong order, does not compile.
template <typename Enum>
struct Label {
  Enum value;
  std::string_view name;      // snake_case
  std::string_view sentence;  // without a full stop
};

// `labels` has every value from 0 to `last`, in order.
template <typename Enum, std::size_t size>
constexpr bool complete(const std::array<Label<Enum>, size>& labels, Enum last) {
  if (size != static_cast<std::size_t>(last) + 1) return false;
  for (std::size_t i = 0; i < size; ++i) {
    if (static_cast<std::size_t>(labels[i].value) != i || labels[i].name.empty()) return false;
  }
  return true;
}

// Of a value in a complete list.
template <typename Enum, std::size_t size>
constexpr const Label<Enum>& label(const std::array<Label<Enum>, size>& labels, Enum value) {
  return labels[static_cast<std::size_t>(value)];
}

// All values of an enum that has `count` of them.
template <typename Enum, std::size_t count>
constexpr std::array<Enum, count> values() {
  std::array<Enum, count> all{};
  for (std::size_t i = 0; i < count; ++i) all[i] = static_cast<Enum>(i);
  return all;
}

}  // namespace tims::core
