// Messages from what people write: "vx=200", "pos.x=1.5", "points[0].angle=0.1". Names are those
// that print.h gives the fields; the fields say themselves what they take.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "rack/codec/print.h"
#include "tims/result.h"

namespace rack {

struct Assignment {
  std::string_view field;  // "pos.x"
  std::string_view value;  // "100", and with the unit of the wire or SI: "100mm", "0.1m"
};

// Sets one number, text or address of a message. Numbers without a unit are those of the wire, or
// with style.si in SI units. The elements of a sequence are set in their order: one behind the last
// makes it longer. Fails with kInvalidArgument, and changes nothing then.
template <Struct T>
tims::Result<void> assign(T& message, const Assignment& assignment, const PrintStyle& style = {});

// --- how

namespace parse {

using tims::Result;

tims::Error no_field(std::string_view type, std::string_view path);
tims::Error bad_value(const Assignment& a, std::string_view wanted);
tims::Error bad_number(const Assignment& a, std::string_view unit);
tims::Error bad_whole(const Assignment& a, i64 min, std::uint64_t max);
tims::Error bad_index(const Assignment& a, std::size_t there, std::size_t max);

// "pos" of "pos.x" and "points[3]", which leaves ".x" and "[3]".
std::string_view take_name(std::string_view& path);
// 3 of "[3].x", which leaves ".x".
std::optional<std::size_t> take_index(std::string_view& path);
// Pairs of digits; nothing when it is none.
std::optional<std::string> bytes_of(std::string_view digits);

// "200", "200mm/s", "0.2 m/s": the number, and whether it is one in SI units.
struct Measure {
  std::string_view number;
  bool si = false;
};
std::optional<Measure> measure(std::string_view text, std::string_view unit,
                               std::string_view si_unit, bool si);

// All of the text, as a number.
template <typename T>
std::optional<T> number(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc() || stop != end) return std::nullopt;
  return value;
}

template <Number T>
tims::Error bad_number(const Assignment& a) {
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    return bad_whole(a, Limits::min(), Limits::max());
  } else {
    return bad_number(a, "");
  }
}

template <Number T>
Result<void> set_number(T& field, const Assignment& a) {
  using Raw = std::conditional_t<std::same_as<T, std::byte>, u8, T>;
  const auto value = number<Raw>(a.value);
  if (!value) return bad_number<Raw>(a);
  field = static_cast<T>(*value);
  return {};
}

template <QuantityLike T>
Result<void> set_quantity(T& field, const Assignment& a, bool si) {
  using Raw = RawOf<T>;
  const auto read = measure(a.value, T::Unit::kName, print::si_unit_of<T>(), si);
  if (!read) return bad_number(a, T::Unit::kName);
  if (!read->si) {
    Raw raw{};
    const auto set = set_number(raw, {a.field, read->number});
    if (set) field = raw;
    return set;
  }
  const auto value = number<f64>(read->number);
  if (!value) return bad_number(a, print::si_unit_of<T>());
  if constexpr (std::is_integral_v<Raw>) {
    using Limits = std::numeric_limits<Raw>;
    const f64 raw = *value / T::Unit::kSi;
    const bool fits =
        raw >= static_cast<f64>(Limits::min()) && raw <= static_cast<f64>(Limits::max());
    if (!fits) return bad_number<Raw>(a);
  }
  field = T::from_si(*value);
  return {};
}

template <print::Leaf T>
Result<void> set_leaf(T& field, const Assignment& a, const PrintStyle& style) {
  if constexpr (kIsText<T>) {
    T text;
    if (!text.assign(a.value)) {
      return bad_value(a, "a text of at most " + std::to_string(T::kBytes - 1) + " bytes");
    }
    field = text;
    return {};
  } else if constexpr (std::same_as<T, tims::Address>) {
    const auto address = a.value == "none" ? kNobody : tims::Address::parse(a.value, style.widths);
    if (!address) return bad_value(a, "an address, or none");
    field = *address;
    return {};
  } else if constexpr (QuantityLike<T>) {
    return set_quantity(field, a, style.si);
  } else if constexpr (std::same_as<T, TimeStamp>) {
    Milliseconds<u32> time = field.raw();
    auto set = set_quantity(time, a, style.si);
    if (set) field = time.raw();
    return set;
  } else {
    static_assert(Number<T>);
    return set_number(field, a);
  }
}

template <typename T>
Result<void> set_blob(T& field, const Assignment& a) {
  constexpr bool kText = std::same_as<typename T::Element, char>;
  const auto bytes = kText ? std::string(a.value) : bytes_of(a.value);
  if (!bytes) return bad_value(a, "pairs of hex digits");
  if (bytes->size() > T::kMax) {
    return bad_value(a, "at most " + std::to_string(T::kMax) + " bytes");
  }
  field.resize(bytes->size());
  for (std::size_t i = 0; i < bytes->size(); ++i) {
    field[i] = static_cast<typename T::Element>((*bytes)[i]);
  }
  return {};
}

template <typename T>
Result<void> set(T& field, std::string_view path, const Assignment& a, const PrintStyle& style);

template <typename T>
Result<void> set_element(T& list, std::string_view path, const Assignment& a,
                         const PrintStyle& style) {
  const auto index = take_index(path);
  if constexpr (kIsVariable<T>) {
    if (!index || *index > list.size() || *index >= T::kMax) {
      return bad_index(a, list.size(), T::kMax);
    }
    const bool longer = *index == list.size();
    if (longer) list.emplace_back();
    const auto done = set(list[*index], path, a, style);
    if (!done && longer) list.pop_back();
    return done;
  } else {
    if (!index || *index >= list.size()) return bad_index(a, list.size(), list.size());
    return set(list[*index], path, a, style);
  }
}

template <Struct T>
Result<void> set_field(T& message, std::string_view path, const Assignment& a,
                       const PrintStyle& style) {
  const std::string_view name = take_name(path);
  Result<void> done = no_field(reflect::kTypeName<T>, name);
  reflect::all_fields(message, [&](auto& field, auto index) {
    if (reflect::kFieldName<T, index> != name) return true;
    done = set(field, path, a, style);
    return false;
  });
  return done;
}

template <typename T>
Result<void> set(T& field, std::string_view path, const Assignment& a, const PrintStyle& style) {
  if constexpr (kIsCount<T>) {
    return bad_value(a, "not given: it is counted");
  } else if constexpr (print::Leaf<T>) {
    if (!path.empty()) return no_field(print::type_of<T>(), path);
    return set_leaf(field, a, style);
  } else if constexpr (print::kIsBlob<T>) {
    if (!path.empty()) return no_field("a text or bytes", path);
    return set_blob(field, a);
  } else if constexpr (kIsArray<T> || kIsVariable<T>) {
    return set_element(field, path, a, style);
  } else {
    if (path.empty()) return bad_value(a, "not given as a whole, but field by field");
    return set_field(field, path.substr(path.starts_with('.') ? 1 : 0), a, style);
  }
}

}  // namespace parse

template <Struct T>
tims::Result<void> assign(T& message, const Assignment& assignment, const PrintStyle& style) {
  return parse::set_field(message, assignment.field, assignment, style);
}

}  // namespace rack
