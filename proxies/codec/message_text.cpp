#include "rack/codec/message_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "base/text.h"

namespace rack {

namespace {

using tims::base::parse_number;
using Values = std::vector<MessageValue>;

// --- texts of numbers

template <typename T>
void append(std::string& out, T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) {
      out += std::isnan(value) ? "nan" : value < 0 ? "-inf" : "inf";
      return;
    }
  }
  std::array<char, 32> text{};  // the longest double has 24 characters
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

void append_number(std::string& out, const MessageValue& value) {
  std::visit(
      [&]<typename Held>(const Held& held) {
        if constexpr (std::is_arithmetic_v<Held>) append(out, held);
      },
      value.is);
}

void append_leaf(std::string& out, const SchemaField& field, const MessageValue& value,
                 const PrintStyle& style) {
  if (field.type == FieldType::kText) return append_quoted(out, value.text());
  if (field.type == FieldType::kAddress)
    return append_quoted(out, value.address().to_string(style.widths));
  if (!style.si || field.si == 1) return append_number(out, value);
  // Divides where the result is exact: 1001 mm is 1.001 m, not 1.0009999999999999.
  const auto raw = value.number<f64>();
  const f64 si = field.si < 1 ? raw / (1 / field.si) : raw * field.si;
  field.type == FieldType::kF32 ? append(out, static_cast<f32>(si)) : append(out, si);
}

void append_blob(std::string& out, const SchemaField& field, const MessageValue& value,
                 const PrintStyle& style) {
  const auto first = std::string_view(value.text()).substr(0, style.elements_max);
  if (field.type == FieldType::kChar) return append_quoted(out, first);
  out.append("\"").append(tims::base::to_hex(std::as_bytes(std::span(first)))).append("\"");
}

// Whether JSON can express the value only as null.
bool is_null(const SchemaField& field, const MessageValue& value) {
  if (field.type == FieldType::kAddress) return value.address() == kNobody;
  if (const auto* number = std::get_if<f32>(&value.is)) return !std::isfinite(*number);
  if (const auto* number = std::get_if<f64>(&value.is)) return !std::isfinite(*number);
  return false;
}

// --- JSON

void append_json(std::string& out, const Schema& schema, const Values& values,
                 const PrintStyle& style);

void append_json_one(std::string& out, const SchemaField& field, const MessageValue& value,
                     const PrintStyle& style) {
  if (field.type == FieldType::kStruct) {
    append_json(out, *field.inner, value.list(), style);
  } else if (is_null(field, value)) {
    out += "null";
  } else {
    append_leaf(out, field, value, style);
  }
}

void append_json_field(std::string& out, const SchemaField& field, const MessageValue& value,
                       const PrintStyle& style) {
  if (field.repeat == Repeat::kNot) return append_json_one(out, field, value, style);
  if (field.is_blob()) return append_blob(out, field, value, style);
  const Values& list = value.list();
  const std::size_t size =
      field.is_variable() ? std::min(list.size(), style.elements_max) : list.size();
  out += '[';
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) out += ',';
    append_json_one(out, field, list[i], style);
  }
  out += ']';
}

void append_json(std::string& out, const Schema& schema, const Values& values,
                 const PrintStyle& style) {
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const SchemaField& field = schema.fields[i];
    out += i == 0 ? '{' : ',';
    append_quoted(out, field.name);
    out += ':';
    if (field.type == FieldType::kCount) {
      append(out, counted(schema, values, i));
    } else {
      append_json_field(out, field, values[i], style);
    }
  }
  out += '}';
}

// --- text

// Of an element "x 100 mm, y 0 mm", of a single number "100 mm".
void append_inline(std::string& out, const SchemaField& field, const MessageValue& value,
                   const PrintStyle& style);

void append_inline_one(std::string& out, const SchemaField& field, const MessageValue& value,
                       const PrintStyle& style) {
  if (field.type == FieldType::kAddress) {
    const tims::Address address = value.address();
    out += address == kNobody ? "none" : address.to_string(style.widths);
  } else if (field.type != FieldType::kStruct) {
    append_leaf(out, field, value, style);
    const std::string_view unit = style.si ? field.si_unit : field.unit;
    if (!unit.empty() && unit != "1") out.append(" ").append(unit);
  } else {
    const Schema& schema = *field.inner;
    for (std::size_t i = 0; i < schema.fields.size(); ++i) {
      if (i > 0) out += ", ";
      out.append(schema.fields[i].name).append(" ");
      append_inline(out, schema.fields[i], value.list()[i], style);
    }
  }
}

void append_inline(std::string& out, const SchemaField& field, const MessageValue& value,
                   const PrintStyle& style) {
  if (field.repeat == Repeat::kNot) return append_inline_one(out, field, value, style);
  const Values& list = value.list();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) out += ' ';
    append_inline_one(out, field, list[i], style);
  }
}

// "name: ... \n", or "name ..." with ", " before it.
void begin_entry(std::string& out, std::string_view name, const PrintStyle& style) {
  if (style.one_line && !out.empty()) out += ", ";
  out.append(name).append(style.one_line ? " " : ": ");
}

void end_entry(std::string& out, const PrintStyle& style) {
  if (!style.one_line) out += '\n';
}

void append_text_list(std::string& out, const std::string& name, const SchemaField& field,
                      const Values& list, const PrintStyle& style) {
  const std::size_t size = std::min(list.size(), style.elements_max);
  for (std::size_t i = 0; i < size; ++i) {
    begin_entry(out, name + "[" + std::to_string(i) + "]", style);
    if (style.one_line) out += '(';
    append_inline_one(out, field, list[i], style);
    if (style.one_line) out += ')';
    end_entry(out, style);
  }
  if (size < list.size()) {
    begin_entry(out, name, style);
    out.append(std::to_string(list.size() - size)).append(" more");
    end_entry(out, style);
  }
}

void append_text(std::string& out, const std::string& prefix, const Schema& schema,
                 const Values& values, const PrintStyle& style) {
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const SchemaField& field = schema.fields[i];
    const std::string name = prefix + std::string(field.name);
    if (field.type == FieldType::kStruct && field.repeat == Repeat::kNot) {
      append_text(out, name + ".", *field.inner, values[i].list(), style);
      continue;
    }
    if (field.is_variable() && !field.is_blob()) {
      append_text_list(out, name, field, values[i].list(), style);
      continue;
    }
    begin_entry(out, name, style);
    if (field.type == FieldType::kCount) {
      append(out, counted(schema, values, i));
    } else if (field.is_blob()) {
      append_blob(out, field, values[i], style);
    } else {
      append_inline(out, field, values[i], style);
    }
    end_entry(out, style);
  }
}

// --- lines of numbers

void append_numbers(std::string& out, const Schema& schema, const Values& values);

void append_item(std::string& out, std::string_view item) {
  if (!out.empty()) out += ' ';
  out += item;
}

void append_numbers_one(std::string& out, const SchemaField& field, const MessageValue& value) {
  if (field.type == FieldType::kStruct) return append_numbers(out, *field.inner, value.list());
  std::string item;
  if (field.type == FieldType::kText) {
    append_quoted(item, value.text());
  } else if (field.type == FieldType::kF32 || field.type == FieldType::kF64) {
    const bool is_double = field.type == FieldType::kF64;  // places on Earth
    std::array<char, 400> digits;
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), value.number<f64>(),
                      std::chars_format::fixed, is_double ? 16 : 6)
            .ptr;
    item.assign(digits.data(), end);
  } else {
    append_number(item, value);
  }
  append_item(out, item);
}

void append_numbers(std::string& out, const Schema& schema, const Values& values) {
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const SchemaField& field = schema.fields[i];
    if (field.type == FieldType::kCount) {
      append_item(out, std::to_string(counted(schema, values, i)));
    } else if (field.is_blob()) {
      std::string item;
      append_blob(item, field, values[i], {});
      append_item(out, item);
    } else if (field.repeat == Repeat::kNot) {
      append_numbers_one(out, field, values[i]);
    } else {
      for (const MessageValue& element : values[i].list()) append_numbers_one(out, field, element);
    }
  }
}

// --- input

tims::Error invalid(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

tims::Error no_field(std::string_view type, std::string_view path) {
  std::string text(type);
  text += " has no field ";
  append_quoted(text, path);
  return invalid(std::move(text));
}

tims::Error bad_value(const Assignment& a, std::string_view wanted) {
  return invalid(
      std::string(a.field).append("=").append(a.value).append(": expected ").append(wanted));
}

template <typename T>
tims::Error bad_number(const Assignment& a, std::string_view unit = {}) {
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    return bad_value(a, "a whole number from " + std::to_string(Limits::min()) + " to " +
                            std::to_string(Limits::max()));
  } else {
    return bad_value(a, std::string("a number").append(unit.empty() ? "" : " in ").append(unit));
  }
}

// Removes and returns "pos" of "pos.x" and "points[3]"; the path becomes ".x" and "[3]".
std::string_view take_name(std::string_view& path) {
  const std::string_view name = path.substr(0, path.find_first_of(".["));
  path.remove_prefix(name.size());
  return name;
}

// Removes and returns 3 of "[3].x"; the path becomes ".x".
std::optional<std::size_t> take_index(std::string_view& path) {
  const std::size_t end = path.find(']');
  if (!path.starts_with('[') || end == std::string_view::npos) return std::nullopt;
  const auto index = parse_number<std::size_t>(path.substr(1, end - 1));
  path.remove_prefix(end + 1);
  return index;
}

// "200", "200mm/s", "0.2 m/s": the number, and whether it is in SI units.
struct Measure {
  std::string_view number;
  bool si = false;
};
std::optional<Measure> measure(std::string_view text, const SchemaField& field, bool si) {
  f64 ignored = 0;
  const char* const end = text.data() + text.size();
  const auto stop = std::from_chars(text.data(), end, ignored).ptr;
  const auto size = static_cast<std::size_t>(stop - text.data());
  std::string_view behind = text.substr(size);
  while (behind.starts_with(' ')) behind.remove_prefix(1);
  const std::string_view digits = text.substr(0, size);
  if (behind.empty()) return Measure{digits, si};
  if (behind == field.unit) return Measure{digits, false};
  if (behind == field.si_unit) return Measure{digits, true};
  return std::nullopt;
}

template <typename T>
Result<void> set_number(MessageValue& value, const Assignment& a) {
  const auto number = parse_number<T>(a.value);
  if (!number) return bad_number<T>(a);
  value = MessageValue::of_number(*number);
  return {};
}

template <typename T>
Result<void> set_quantity(const SchemaField& field, MessageValue& value, const Assignment& a,
                          bool si) {
  const auto read = measure(a.value, field, si);
  if (!read) return bad_value(a, "a number in " + std::string(field.unit));
  if (!read->si) return set_number<T>(value, {a.field, read->number});
  const auto number = parse_number<f64>(read->number);
  if (!number) return bad_value(a, "a number in " + std::string(field.si_unit));
  const f64 raw = *number / field.si;
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    if (!(raw >= static_cast<f64>(Limits::min()) && raw <= static_cast<f64>(Limits::max())))
      return bad_number<T>(a);
    // The largest i64 cannot be represented as a double; 2^63 can.
    value = MessageValue::of_number(
        raw >= static_cast<f64>(Limits::max()) ? Limits::max() : static_cast<T>(std::round(raw)));
  } else {
    value = MessageValue::of_number(static_cast<T>(raw));
  }
  return {};
}

Result<void> set_leaf(const SchemaField& field, MessageValue& value, const Assignment& a,
                      const PrintStyle& style) {
  if (field.type == FieldType::kText) {
    if (a.value.size() >= field.size || a.value.find('\0') != std::string_view::npos)
      return bad_value(a, "a text of at most " + std::to_string(field.size - 1) + " bytes");
    value = {std::string(a.value)};
    return {};
  }
  if (field.type == FieldType::kAddress) {
    const auto address = a.value == "none" ? kNobody : tims::Address::parse(a.value, style.widths);
    if (!address) return bad_value(a, "an address, or none");
    value = MessageValue::of_number(address->raw());
    return {};
  }
  return with_number(field.type, [&]<typename T>(T) -> Result<void> {
    return field.unit.empty() ? set_number<T>(value, a)
                              : set_quantity<T>(field, value, a, style.si);
  });
}

Result<void> set_blob(const SchemaField& field, MessageValue& value, const Assignment& a) {
  std::string bytes(a.value);
  if (field.type == FieldType::kByte) {
    const auto given = tims::base::parse_hex(a.value);
    if (!given) return bad_value(a, "pairs of hex digits");
    bytes.assign(reinterpret_cast<const char*>(given->data()), given->size());
  }
  if (bytes.size() > field.times)
    return bad_value(a, "at most " + std::to_string(field.times) + " bytes");
  value = {std::move(bytes)};
  return {};
}

Result<void> set_in(const Schema& schema, Values& values, std::string_view path,
                    const Assignment& a, const PrintStyle& style);

Result<void> set_one(const SchemaField& field, MessageValue& value, std::string_view path,
                     const Assignment& a, const PrintStyle& style) {
  if (field.type != FieldType::kStruct) {
    const bool wraps = field.type == FieldType::kTime;
    if (!path.empty()) return no_field(name(wraps ? FieldType::kU32 : field.type), path);
    return set_leaf(field, value, a, style);
  }
  if (path.empty()) return bad_value(a, "a value for each field, not for the whole");
  return set_in(*field.inner, value.list(), path.substr(path.starts_with('.') ? 1 : 0), a, style);
}

Result<void> set_element(const SchemaField& field, Values& list, std::string_view path,
                         const Assignment& a, const PrintStyle& style) {
  const auto index = take_index(path);
  const std::size_t behind = field.is_variable() ? list.size() + 1 : list.size();
  if (!index || *index >= std::min(behind, field.times)) {
    const std::size_t last =
        std::min(field.is_variable() ? list.size() : field.times - 1, field.times - 1);
    return invalid(std::string(a.field) + ": expected an index up to " + std::to_string(last) +
                   "; elements are set in their order");
  }
  if (*index < list.size()) return set_one(field, list[*index], path, a, style);
  MessageValue made = made_value(field);
  auto done = set_one(field, made, path, a, style);
  if (done) list.push_back(std::move(made));
  return done;
}

Result<void> set_in(const Schema& schema, Values& values, std::string_view path,
                    const Assignment& a, const PrintStyle& style) {
  const std::string_view name = take_name(path);
  const auto field = std::ranges::find(schema.fields, name, &SchemaField::name);
  if (field == schema.fields.end()) return no_field(schema.name, name);
  MessageValue& value = values[static_cast<std::size_t>(field - schema.fields.begin())];
  if (field->type == FieldType::kCount) return bad_value(a, "no value: the elements are counted");
  if (field->repeat == Repeat::kNot) return set_one(*field, value, path, a, style);
  if (!field->is_blob()) return set_element(*field, value.list(), path, a, style);
  if (!path.empty()) return no_field("a text or bytes", path);
  return set_blob(*field, value, a);
}

// --- columns

void append_columns(std::vector<Column>& out, const std::string& prefix, const Schema& schema);

void append_columns_one(std::vector<Column>& out, const std::string& name,
                        const SchemaField& field) {
  if (field.type == FieldType::kStruct) return append_columns(out, name + ".", *field.inner);
  const bool wraps = field.type == FieldType::kTime;
  out.push_back(
      {name, field.unit, field.si_unit, rack::name(wraps ? FieldType::kU32 : field.type)});
}

void append_columns(std::vector<Column>& out, const std::string& prefix, const Schema& schema) {
  for (const SchemaField& field : schema.fields) {
    const std::string name = prefix + std::string(field.name);
    if (field.repeat == Repeat::kNot) {
      append_columns_one(out, name, field);
    } else if (field.is_variable()) {
      append_columns_one(out, name + "[]", field);
    } else {
      for (std::size_t i = 0; i < field.times; ++i)
        append_columns_one(out, name + "[" + std::to_string(i) + "]", field);
    }
  }
}

}  // namespace

// --- public functions

Result<void> assign(const Schema& schema, MessageValue& value, const Assignment& assignment,
                    const PrintStyle& style) {
  return set_in(schema, value.list(), assignment.field, assignment, style);
}

std::string to_json(const Schema& schema, const MessageValue& value, const PrintStyle& style) {
  std::string out;
  append_json(out, schema, value.list(), style);
  return out;
}

std::string to_text(const Schema& schema, const MessageValue& value, const PrintStyle& style) {
  std::string out;
  append_text(out, "", schema, value.list(), style);
  return out;
}

std::string to_numbers(const Schema& schema, const MessageValue& value) {
  std::string out;
  append_numbers(out, schema, value.list());
  return out;
}

void append_quoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c >= ' ' && c <= '~') {
      out += c;
    } else {
      const auto value = static_cast<unsigned char>(c);
      out.append("\\u00").append(tims::base::to_hex(std::array{std::byte{value}}));
    }
  }
  out += '"';
}

Result<std::string> body_json(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style) {
  const auto value = read_value(schema, body, order);
  if (!value) return value.error();
  return to_json(schema, *value, style);
}

Result<std::string> body_text(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style) {
  const auto value = read_value(schema, body, order);
  if (!value) return value.error();
  return to_text(schema, *value, style);
}

Result<std::vector<std::byte>> make_body(const Schema& schema, std::span<const Assignment> set,
                                         std::endian order, const PrintStyle& style) {
  MessageValue value = made_value(schema);
  for (const Assignment& field : set)
    if (const auto done = assign(schema, value, field, style); !done) return done.error();
  return write_value(schema, value, order);
}

std::vector<Column> columns_of(const Schema& schema) {
  std::vector<Column> out;
  append_columns(out, "", schema);
  return out;
}

}  // namespace rack
