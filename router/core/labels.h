// Closed lists: an enum, and for each of its values one word for JSON and metrics and one sentence
// for people. A list that misses a value, or has two of them in the wrong order, does not compile.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace tims::core {

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
