// Field types of message structs, in addition to numbers and structs of numbers, and their size on
// the wire.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "rack/codec/reflect.h"
#include "tims/text.h"

namespace rack {

// --- fields of variable length

// In a message struct, the number (i32) of elements of the next sequence, which follows immediately
// or some fields later. It has no value in memory: the sequence knows its size.
//
//   struct LadarData {
//     ...
//     Count pointNum;
//     Sequence<LadarPoint, 2160> points;
//   };
struct Count {
  bool operator==(const Count&) const = default;
};

// A vector that may have at most Max elements when it is encoded or decoded. After reserve_all() it
// never allocates again, also not when a message is decoded into it.
template <typename T, std::size_t Max>
struct Sequence : std::vector<T> {
  using Element = T;
  static constexpr std::size_t kMax = Max;

  using std::vector<T>::vector;
  void reserve_all() { this->reserve(Max); }
};

// A sequence whose length follows from other fields, such as the pixels of an image. Its struct
// computes the lengths in a member function, one for each tail in their order; negative means
// invalid:
//
//   [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const { return {width * height}; }
template <typename T, std::size_t Max>
struct Tail : std::vector<T> {
  using Element = T;
  static constexpr std::size_t kMax = Max;

  using std::vector<T>::vector;
  void reserve_all() { this->reserve(Max); }
};

// --- a text in a fixed number of bytes, such as a file name

using tims::Text;

// --- kinds of fields

// A plain number; a byte is a number without byte order and sign.
template <typename T>
concept Number = std::is_arithmetic_v<T> || std::same_as<T, std::byte>;

// A class with a single number: Quantity, TimeStamp, tims::Address.
template <typename T>
concept WrappedNumber = !Number<T> && requires(const T value) {
  { value.raw() } -> Number;
  T(value.raw());
};

template <typename T>
concept QuantityLike = WrappedNumber<T> && requires { T::Unit::kName; };

template <WrappedNumber T>
using RawOf = decltype(std::declval<const T&>().raw());

template <typename T>
inline constexpr bool kIsText = false;
template <std::size_t N>
inline constexpr bool kIsText<Text<N>> = true;

template <typename T>
inline constexpr bool kIsArray = false;
template <typename T, std::size_t N>
inline constexpr bool kIsArray<std::array<T, N>> = true;

template <typename T>
inline constexpr bool kIsSequence = false;
template <typename T, std::size_t Max>
inline constexpr bool kIsSequence<Sequence<T, Max>> = true;

template <typename T>
inline constexpr bool kIsTail = false;
template <typename T, std::size_t Max>
inline constexpr bool kIsTail<Tail<T, Max>> = true;

template <typename T>
inline constexpr bool kIsCount = std::same_as<T, Count>;
template <typename T>
inline constexpr bool kIsVariable = kIsSequence<T> || kIsTail<T>;

// Everything else is a struct of such fields.
template <typename T>
concept Struct = std::is_aggregate_v<T> && !kIsArray<T> && !kIsCount<T> && !kIsVariable<T>;

// Size without the elements of sequences and tails: the minimum size of such a message.
template <typename T>
consteval std::size_t wire_size() {
  if constexpr (Number<T>) {
    return sizeof(T);
  } else if constexpr (WrappedNumber<T>) {
    static_assert(sizeof(T) == sizeof(RawOf<T>));
    return sizeof(T);
  } else if constexpr (kIsText<T>) {
    return T::kBytes;
  } else if constexpr (kIsArray<T>) {
    return std::tuple_size_v<T> * wire_size<typename T::value_type>();
  } else if constexpr (kIsCount<T>) {
    return sizeof(std::int32_t);
  } else if constexpr (kIsVariable<T>) {
    return 0;
  } else {
    static_assert(Struct<T>);
    return reflect::sum_over_fields<T>(
        []<typename Field, std::size_t>() { return wire_size<Field>(); });
  }
}

// Largest number of bytes of the elements of all sequences and tails.
template <Struct T>
consteval std::size_t elements_max() {
  return reflect::sum_over_fields<T>([]<typename Field, std::size_t>() -> std::size_t {
    if constexpr (kIsVariable<Field>) {
      return Field::kMax * wire_size<typename Field::Element>();
    } else {
      return 0;
    }
  });
}

// The largest body of this message: the body_max that a mailbox needs to receive it.
template <Struct T>
consteval std::size_t body_max() {
  if constexpr (requires { T::kBodyMax; }) {
    return T::kBodyMax;
  } else if constexpr (requires { T::kWholeSize; }) {
    return T::kWholeSize;
  } else if constexpr (requires { T::kSurplus; }) {
    return wire_size<T>() + elements_max<T>() + T::kSurplus;
  } else {
    return wire_size<T>() + elements_max<T>();
  }
}

// Memory layout and wire layout (in native order) are identical, so it can be copied as a block.
template <typename T>
consteval bool is_plain() {
  if constexpr (Number<T> || WrappedNumber<T>) {
    return std::is_trivially_copyable_v<T>;
  } else if constexpr (kIsArray<T>) {
    return is_plain<typename T::value_type>();
  } else if constexpr (Struct<T>) {
    constexpr std::size_t kPlainFields = reflect::sum_over_fields<T>(
        []<typename Field, std::size_t>() -> std::size_t { return is_plain<Field>() ? 1 : 0; });
    return kPlainFields == reflect::kFieldCount<T> && sizeof(T) == wire_size<T>();
  } else {
    return false;
  }
}

// The sequence that the count at field I belongs to: the next one.
template <typename T, std::size_t I>
consteval std::size_t sequence_of_count() {
  static_assert(I + 1 < reflect::kFieldCount<T>, "a count without a sequence behind it");
  if constexpr (kIsSequence<reflect::Field<T, I + 1>>) {
    return I + 1;
  } else {
    return sequence_of_count<T, I + 1>();
  }
}

// Sequences and tails must be the last fields: a body of at least wire_size bytes then contains all
// other fields.
template <typename T>
consteval bool variable_fields_last() {
  bool variable = false;
  bool last = true;
  reflect::sum_over_fields<T>([&]<typename Field, std::size_t>() -> std::size_t {
    variable = variable || kIsVariable<Field>;
    last = last && variable == kIsVariable<Field>;
    return 0;
  });
  return last;
}

// Number of tails before field I.
template <typename T, std::size_t I>
consteval std::size_t tails_before() {
  return reflect::sum_over_fields<T>([]<typename Field, std::size_t J>() -> std::size_t {
    return J < I && kIsTail<Field> ? 1 : 0;
  });
}

}  // namespace rack
