// Messages for people and for other programs, from what the compiler knows of their fields. Numbers
// are those of the wire, in its units.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proxies/codec/layout.h"
#include "proxies/codec/time_stamp.h"
#include "tims/address.h"

namespace rack {

inline constexpr std::size_t kAllElements = std::numeric_limits<std::size_t>::max();

// One line of JSON. Counts are told like other fields. Addresses and texts are strings, bytes are
// strings of hex digits, numbers that are not finite are null. Of a sequence, the first
// `elements_max` elements.
template <Struct T>
std::string to_json(const T& value, std::size_t elements_max = kAllElements);

// One line a number ("pos.x: 100 mm"), and one for each element of a sequence.
template <Struct T>
std::string to_text(const T& value, std::size_t elements_max = kAllElements);

// A number of a message, by the name that to_text() gives it.
struct Column {
  std::string name;       // "pos.x"; of the elements of a sequence "points[].angle"
  std::string_view unit;  // "mm"; empty: none
  bool operator==(const Column&) const = default;
};
// In the order of the wire, with the fields of inner structs one by one.
template <Struct T>
std::vector<Column> columns();

// --- how

namespace print {

void append(std::string& out, std::int64_t value);
void append(std::string& out, std::uint64_t value);
void append(std::string& out, float value);  // shortest that reads back the same
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
    return "ms";
  } else {
    return {};
  }
}

// A field that is printed as one value.
template <typename T>
concept Leaf = Number<T> || WrappedNumber<T> || kIsText<T>;

template <Leaf T>
void append_leaf(std::string& out, const T& value) {
  if constexpr (kIsText<T>) {
    append_quoted(out, value.view());
  } else if constexpr (std::same_as<T, tims::Address>) {
    append_quoted(out, value.to_string());
  } else if constexpr (WrappedNumber<T>) {
    append_number(out, value.raw());
  } else {
    append_number(out, value);
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
void append_blob(std::string& out, const T& blob, std::size_t elements_max) {
  const std::size_t size = std::min(blob.size(), elements_max);
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
void append_json(std::string& out, const T& value, std::size_t elements_max);

template <typename T>
void append_json_list(std::string& out, const T& list, std::size_t elements_max) {
  out += '[';
  const std::size_t size = std::min(list.size(), elements_max);
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) out += ',';
    append_json(out, list[i], elements_max);
  }
  out += ']';
}

template <typename T>
void append_json_struct(std::string& out, const T& value, std::size_t elements_max) {
  reflect::all_fields(value, [&](const auto& field, auto index) {
    out += index == 0 ? '{' : ',';
    append_quoted(out, reflect::kFieldName<T, index>);
    out += ':';
    if constexpr (kIsCount<std::remove_cvref_t<decltype(field)>>) {
      append(out, std::uint64_t{counted<T, index>(value)});
    } else {
      append_json(out, field, elements_max);
    }
    return true;
  });
  out += '}';
}

template <typename T>
void append_json(std::string& out, const T& value, std::size_t elements_max) {
  if constexpr (Leaf<T>) {
    append_leaf(out, value);
  } else if constexpr (kIsArray<T>) {
    append_json_list(out, value, kAllElements);
  } else if constexpr (kIsBlob<T>) {
    append_blob(out, value, elements_max);
  } else if constexpr (kIsVariable<T>) {
    append_json_list(out, value, elements_max);
  } else {
    append_json_struct(out, value, elements_max);
  }
}

// --- text

// "x 100 mm, y 0 mm" of an element, and "100 mm" of a single number.
template <typename T>
void append_inline(std::string& out, const T& value) {
  if constexpr (Leaf<T>) {
    append_leaf(out, value);
    if constexpr (!unit_of<T>().empty()) out.append(" ").append(unit_of<T>());
  } else if constexpr (kIsArray<T>) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i > 0) out += ' ';
      append_inline(out, value[i]);
    }
  } else {
    reflect::all_fields(value, [&](const auto& field, auto index) {
      if (index > 0) out += ", ";
      out.append(reflect::kFieldName<T, index>).append(" ");
      append_inline(out, field);
      return true;
    });
  }
}

template <typename T>
void append_text_list(std::string& out, const std::string& name, const T& list,
                      std::size_t elements_max) {
  const std::size_t size = std::min(list.size(), elements_max);
  for (std::size_t i = 0; i < size; ++i) {
    out.append(name).append("[").append(std::to_string(i)).append("]: ");
    append_inline(out, list[i]);
    out += '\n';
  }
  if (size < list.size()) {
    out.append(name).append(": ").append(std::to_string(list.size() - size)).append(" more\n");
  }
}

template <typename T>
void append_text(std::string& out, const std::string& prefix, const T& value,
                 std::size_t elements_max) {
  reflect::all_fields(value, [&](const auto& field, auto index) {
    using Field = std::remove_cvref_t<decltype(field)>;
    const std::string name = prefix + std::string(reflect::kFieldName<T, index>);
    if constexpr (Struct<Field>) {
      append_text(out, name + ".", field, elements_max);
    } else if constexpr (kIsVariable<Field> && !kIsBlob<Field>) {
      append_text_list(out, name, field, elements_max);
    } else {
      out.append(name).append(": ");
      if constexpr (kIsCount<Field>) {
        append(out, std::uint64_t{counted<T, index>(value)});
      } else if constexpr (kIsBlob<Field>) {
        append_blob(out, field, elements_max);
      } else {
        append_inline(out, field);
      }
      out += '\n';
    }
    return true;
  });
}

// --- columns

template <typename T>
void append_columns(std::vector<Column>& out, const std::string& name) {
  if constexpr (Leaf<T> || kIsCount<T>) {
    out.push_back({name, unit_of<T>()});
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
std::string to_json(const T& value, std::size_t elements_max) {
  std::string out;
  print::append_json(out, value, elements_max);
  return out;
}

template <Struct T>
std::string to_text(const T& value, std::size_t elements_max) {
  std::string out;
  print::append_text(out, "", value, elements_max);
  return out;
}

template <Struct T>
std::vector<Column> columns() {
  std::vector<Column> out;
  print::append_columns<T>(out, "");
  return out;
}

}  // namespace rack
