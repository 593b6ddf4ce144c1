// Messages for people and for other programs, from what the compiler knows of their fields. Numbers
// are those of the wire, in its units, unless SI is asked for. (Angles stay clockwise.)
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/layout.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"

namespace rack {

inline constexpr std::size_t kAllElements = std::numeric_limits<std::size_t>::max();

// What stands in an address field that names nobody, such as the active pilot when there is none.
inline constexpr tims::Address kNobody{0xFFFFFF00};

struct PrintStyle {
  std::size_t elements_max = kAllElements;  // of a sequence, the first ones
  bool si = false;                          // numbers in SI units
  bool one_line = false;                    // of text: "pos.x 100 mm, pos.y 0 mm"
  tims::AddressWidths widths{};
};

// One line of JSON. Counts are told like other fields. Addresses and texts are strings, bytes are
// strings of hex digits; numbers that are not finite, and an address that is nobody's, are null.
template <Struct T>
std::string to_json(const T& value, const PrintStyle& style = {});

// One line a number ("pos.x: 100 mm"), and one for each element of a sequence.
template <Struct T>
std::string to_text(const T& value, const PrintStyle& style = {});

// A number of a message, by the name that to_text() gives it.
struct Column {
  std::string name;          // "pos.x"; of the elements of a sequence "points[].angle"
  std::string_view unit;     // "mm"; empty: none
  std::string_view si_unit;  // "m"
  std::string_view type;     // "i32", "f32", "address", "text"; "count": of the sequence behind it
  bool operator==(const Column&) const = default;
};
// In the order of the wire, with the fields of inner structs one by one.
template <Struct T>
std::vector<Column> columns();

// --- how

namespace print {

void append(std::string& out, std::int64_t value);
void append(std::string& out, std::uint64_t value);
// The shortest that reads back the same; "inf", "nan".
void append(std::string& out, float value);
void append(std::string& out, double value);
void append_hex(std::string& out, std::span<const std::byte> bytes);
// In quotes. What is no printable ASCII is escaped: nobody knows the character set.
void append_quoted(std::string& out, std::string_view text);

template <Number T>
void append_number(std::string& out, T value) {
  if constexpr (std::same_as<T, std::byte>) {
    append(out, std::to_integer<std::uint64_t>(value));
  } else if constexpr (std::is_floating_point_v<T>) {
    append(out, value);
  } else if constexpr (std::is_signed_v<T>) {
    append(out, std::int64_t{value});
  } else {
    append(out, std::uint64_t{value});
  }
}

template <typename T>
consteval std::string_view unit_of() {
  if constexpr (QuantityLike<T>) {
    return T::Unit::kName;
  } else if constexpr (std::same_as<T, TimeStamp>) {
    return unit::Millisecond::kName;
  } else {
    return {};
  }
}
// What one unit of the wire, times its kSi, is called.
constexpr std::string_view si_name(std::string_view unit) {
  constexpr std::string_view kNames[][2] = {
      {"mm", "m"},       {"mm/s", "m/s"},  {"mm/s2", "m/s2"},     {"1/mm", "1/m"},
      {"1/mm2", "1/m2"}, {"ms", "s"},      {"rad/mm", "rad/m"},   {"%", "1"},
      {"%/s", "1/s"},    {"%/s2", "1/s2"}, {"mm/cell", "m/cell"}, {"mm/(mm/s)", "m/(m/s)"}};
  for (const auto& [wire, si] : kNames) {
    if (wire == unit) return si;
  }
  return unit;
}

template <typename T>
consteval std::string_view si_unit_of() {
  return si_name(unit_of<T>());
}

// "i32" and so on; characters and bytes are told as texts and hex digits.
template <typename T>
consteval std::string_view type_of() {
  if constexpr (kIsCount<T>) {
    return "count";
  } else if constexpr (kIsText<T> || std::same_as<T, char>) {
    return "text";
  } else if constexpr (std::same_as<T, std::byte>) {
    return "byte";
  } else if constexpr (std::same_as<T, tims::Address>) {
    return "address";
  } else if constexpr (WrappedNumber<T>) {
    return type_of<RawOf<T>>();
  } else if constexpr (std::is_floating_point_v<T>) {
    return sizeof(T) == sizeof(f32) ? "f32" : "f64";
  } else if constexpr (std::is_signed_v<T>) {
    return sizeof(T) == 1 ? "i8" : sizeof(T) == 2 ? "i16" : sizeof(T) == 4 ? "i32" : "i64";
  } else {
    return sizeof(T) == 1 ? "u8" : sizeof(T) == 2 ? "u16" : sizeof(T) == 4 ? "u32" : "u64";
  }
}

// A field that is printed as one value.
template <typename T>
concept Leaf = Number<T> || WrappedNumber<T> || kIsText<T>;

template <Leaf T>
void append_leaf(std::string& out, const T& value, const PrintStyle& style) {
  if constexpr (kIsText<T>) {
    append_quoted(out, value.view());
  } else if constexpr (std::same_as<T, tims::Address>) {
    append_quoted(out, value.to_string(style.widths));
  } else if constexpr (QuantityLike<T>) {
    // Divided where that is exact: 1001 mm are 1.001 m, and not 1.0009999999999999.
    constexpr double kSi = T::Unit::kSi;
    const auto raw = static_cast<double>(value.raw());
    const double si = kSi < 1 ? raw / (1 / kSi) : raw * kSi;
    if (!style.si || kSi == 1) {
      append_number(out, value.raw());
    } else if constexpr (std::same_as<RawOf<T>, f32>) {
      append(out, static_cast<f32>(si));
    } else {
      append(out, si);
    }
  } else if constexpr (std::same_as<T, TimeStamp>) {
    style.si ? append(out, value.raw() / 1e3) : append_number(out, value.raw());
  } else if constexpr (WrappedNumber<T>) {
    append_number(out, value.raw());
  } else {
    append_number(out, value);
  }
}

// Whether JSON has no other word for it than null.
template <Leaf T>
bool is_null(const T& value) {
  if constexpr (std::same_as<T, tims::Address>) {
    return value == kNobody;
  } else if constexpr (std::is_floating_point_v<T>) {
    return !std::isfinite(value);
  } else if constexpr (QuantityLike<T>) {
    return is_null(value.raw());
  } else {
    return false;
  }
}

// Sequences of characters and bytes are told as a whole.
template <typename T>
inline constexpr bool kIsBlob = false;
template <typename T>
  requires kIsVariable<T>
inline constexpr bool kIsBlob<T> =
    std::same_as<typename T::Element, char> || std::same_as<typename T::Element, std::byte>;

template <typename T>
void append_blob(std::string& out, const T& blob, const PrintStyle& style) {
  const std::size_t size = std::min(blob.size(), style.elements_max);
  if constexpr (std::same_as<typename T::Element, char>) {
    append_quoted(out, {blob.data(), size});
  } else {
    append_hex(out, std::span(blob).first(size));
  }
}

// How many elements follow the count at field I.
template <typename T, std::size_t I>
std::size_t counted(const T& value) {
  return boost::pfr::get<sequence_of_count<T, I>()>(value).size();
}

// --- JSON

template <typename T>
void append_json(std::string& out, const T& value, const PrintStyle& style);

template <typename T>
void append_json_list(std::string& out, const T& list, std::size_t elements_max,
                      const PrintStyle& style) {
  out += '[';
  const std::size_t size = std::min(list.size(), elements_max);
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) out += ',';
    append_json(out, list[i], style);
  }
  out += ']';
}

template <typename T>
void append_json_struct(std::string& out, const T& value, const PrintStyle& style) {
  reflect::all_fields(value, [&](const auto& field, auto index) {
    out += index == 0 ? '{' : ',';
    append_quoted(out, reflect::kFieldName<T, index>);
    out += ':';
    if constexpr (kIsCount<std::remove_cvref_t<decltype(field)>>) {
      append(out, std::uint64_t{counted<T, index>(value)});
    } else {
      append_json(out, field, style);
    }
    return true;
  });
  out += '}';
}

template <typename T>
void append_json(std::string& out, const T& value, const PrintStyle& style) {
  if constexpr (Leaf<T>) {
    if (is_null(value)) {
      out += "null";
    } else {
      append_leaf(out, value, style);
    }
  } else if constexpr (kIsArray<T>) {
    append_json_list(out, value, kAllElements, style);
  } else if constexpr (kIsBlob<T>) {
    append_blob(out, value, style);
  } else if constexpr (kIsVariable<T>) {
    append_json_list(out, value, style.elements_max, style);
  } else {
    append_json_struct(out, value, style);
  }
}

// --- text

// "x 100 mm, y 0 mm" of an element, and "100 mm" of a single number.
template <typename T>
void append_inline(std::string& out, const T& value, const PrintStyle& style) {
  if constexpr (std::same_as<T, tims::Address>) {
    out += value == kNobody ? "none" : value.to_string(style.widths);
  } else if constexpr (Leaf<T>) {
    append_leaf(out, value, style);
    const std::string_view unit = style.si ? si_unit_of<T>() : unit_of<T>();
    if (!unit.empty() && unit != "1") out.append(" ").append(unit);
  } else if constexpr (kIsArray<T>) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i > 0) out += ' ';
      append_inline(out, value[i], style);
    }
  } else {
    reflect::all_fields(value, [&](const auto& field, auto index) {
      if (index > 0) out += ", ";
      out.append(reflect::kFieldName<T, index>).append(" ");
      append_inline(out, field, style);
      return true;
    });
  }
}

// "name: ... \n", or "name ..." with ", " before it.
void begin_entry(std::string& out, std::string_view name, const PrintStyle& style);
void end_entry(std::string& out, const PrintStyle& style);

template <typename T>
void append_text_list(std::string& out, const std::string& name, const T& list,
                      const PrintStyle& style) {
  const std::size_t size = std::min(list.size(), style.elements_max);
  for (std::size_t i = 0; i < size; ++i) {
    begin_entry(out, name + "[" + std::to_string(i) + "]", style);
    if (style.one_line) out += '(';
    append_inline(out, list[i], style);
    if (style.one_line) out += ')';
    end_entry(out, style);
  }
  if (size < list.size()) {
    begin_entry(out, name, style);
    out.append(std::to_string(list.size() - size)).append(" more");
    end_entry(out, style);
  }
}

template <typename T>
void append_text(std::string& out, const std::string& prefix, const T& value,
                 const PrintStyle& style) {
  reflect::all_fields(value, [&](const auto& field, auto index) {
    using Field = std::remove_cvref_t<decltype(field)>;
    const std::string name = prefix + std::string(reflect::kFieldName<T, index>);
    if constexpr (Struct<Field>) {
      append_text(out, name + ".", field, style);
    } else if constexpr (kIsVariable<Field> && !kIsBlob<Field>) {
      append_text_list(out, name, field, style);
    } else {
      begin_entry(out, name, style);
      if constexpr (kIsCount<Field>) {
        append(out, std::uint64_t{counted<T, index>(value)});
      } else if constexpr (kIsBlob<Field>) {
        append_blob(out, field, style);
      } else {
        append_inline(out, field, style);
      }
      end_entry(out, style);
    }
    return true;
  });
}

// --- columns

template <typename T>
void append_columns(std::vector<Column>& out, const std::string& name) {
  if constexpr (Leaf<T> || kIsCount<T>) {
    out.push_back({name, unit_of<T>(), si_unit_of<T>(), type_of<T>()});
  } else if constexpr (kIsArray<T>) {
    for (std::size_t i = 0; i < std::tuple_size_v<T>; ++i) {
      append_columns<typename T::value_type>(out, name + "[" + std::to_string(i) + "]");
    }
  } else if constexpr (kIsVariable<T>) {
    append_columns<typename T::Element>(out, name + "[]");
  } else {
    reflect::sum_over_fields<T>([&]<typename Field, std::size_t I>() -> std::size_t {
      const std::string dot = name.empty() ? "" : ".";
      append_columns<Field>(out, name + dot + std::string(reflect::kFieldName<T, I>));
      return 0;
    });
  }
}

}  // namespace print

template <Struct T>
std::string to_json(const T& value, const PrintStyle& style) {
  std::string out;
  print::append_json(out, value, style);
  return out;
}

template <Struct T>
std::string to_text(const T& value, const PrintStyle& style) {
  std::string out;
  print::append_text(out, "", value, style);
  return out;
}

template <Struct T>
std::vector<Column> columns() {
  std::vector<Column> out;
  print::append_columns<T>(out, "");
  return out;
}

}  // namespace rack
