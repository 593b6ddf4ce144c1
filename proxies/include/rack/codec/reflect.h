// Compile-time reflection of a message struct: its fields, their names, its own name. Works for
// aggregates of up to 200 fields without C arrays (use std::array).
#pragma once

#include <cstddef>
#include <string_view>
#include <type_traits>
#include <utility>

#include <boost/pfr/core.hpp>
#include <boost/pfr/tuple_size.hpp>

namespace rack::reflect {

template <typename T>
inline constexpr std::size_t kFieldCount = boost::pfr::tuple_size_v<T>;

template <typename T, std::size_t I>
using Field = boost::pfr::tuple_element_t<I, T>;

template <std::size_t I>
using Index = std::integral_constant<std::size_t, I>;

// Clang's path analyser loses the references that Boost.PFR passes on and reports the fields as
// uninitialised. For the analyser, the function therefore only shows that a field exists.
template <std::size_t I, typename T>
using FieldReference =
    std::conditional_t<std::is_const_v<T>, const Field<std::remove_const_t<T>, I>&,
                       Field<std::remove_const_t<T>, I>&>;
#if defined(__clang_analyzer__)
template <std::size_t I, typename T>
FieldReference<I, T> field_of(T& value);
#else
template <std::size_t I, typename T>
constexpr FieldReference<I, T> field_of(T& value) {
  return boost::pfr::get<I>(value);
}
#endif

// Calls visit(field, Index<I>) for each field in order, until one returns false. True: all were
// visited.
template <typename T, typename Visit>
constexpr bool all_fields(T& value, Visit&& visit) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return (... && visit(field_of<I>(value), Index<I>()));
  }(std::make_index_sequence<kFieldCount<std::remove_const_t<T>>>());
}

// Calls visit.operator()<Field, I>() for each field's type, without an object; returns the sum of
// the results.
template <typename T, typename Visit>
constexpr std::size_t sum_over_fields(Visit&& visit) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) -> std::size_t {
    return (std::size_t{0} + ... + visit.template operator()<Field<T, I>, I>());
  }(std::make_index_sequence<kFieldCount<T>>());
}

// --- Names are extracted from the compiler's text for a function with the field as template
// argument: "... ::vx)}]" (g++), "... value.vx}]" (clang)

namespace detail {

template <typename T>
struct Held {
  T value;
};
// Only its address is used: it is never defined, which clang would warn about.
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wundefined-internal"
#pragma clang diagnostic ignored "-Wundefined-var-template"
#endif
template <typename T>
extern const Held<T> held;

template <typename T>
struct PointerTo {
  const T* pointer;
};
template <typename T>
PointerTo(const T*) -> PointerTo<T>;

// The parameter is not a string_view, because g++ appends the definition of that alias.
template <auto P>
constexpr const char* text_of_value() {
  return __PRETTY_FUNCTION__;
}
template <typename T>
constexpr const char* text_of_type() {
  return __PRETTY_FUNCTION__;
}

constexpr bool in_identifier(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

// The last identifier in a text.
constexpr std::string_view last_identifier(std::string_view text) {
  while (!text.empty() && !in_identifier(text.back())) text.remove_suffix(1);
  std::size_t first = text.size();
  while (first > 0 && in_identifier(text[first - 1])) --first;
  return text.substr(first);
}

template <typename T, std::size_t I>
constexpr std::string_view field_name() {
  return last_identifier(text_of_value<PointerTo{&boost::pfr::get<I>(held<T>.value)}>());
}
#if defined(__clang__)
#pragma clang diagnostic pop
#endif

}  // namespace detail

// "recordingTime"
template <typename T, std::size_t I>
inline constexpr std::string_view kFieldName = detail::field_name<T, I>();

// "ChassisData", without namespaces. Not for templates.
template <typename T>
inline constexpr std::string_view kTypeName = detail::last_identifier(detail::text_of_type<T>());

}  // namespace rack::reflect
