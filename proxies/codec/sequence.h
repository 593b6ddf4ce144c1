// The parts of a message whose length differs from message to message.
#pragma once

#include <cstddef>
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

}  // namespace rack
