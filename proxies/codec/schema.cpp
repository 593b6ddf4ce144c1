#include "rack/codec/schema.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

namespace rack {

namespace {

using Bytes = Schema::Bytes;
using Values = std::vector<MessageValue>;

constexpr std::string_view kDigits = "0123456789abcdef";

// Calls use(T{}) with the number that stands on the wire for this type.
template <typename Use>
auto with_number(FieldType type, const Use& use) {
  switch (type) {
    case FieldType::kI8:
    case FieldType::kChar:
      return use(i8{});
    case FieldType::kU8:
    case FieldType::kByte:
      return use(u8{});
    case FieldType::kI16:
      return use(i16{});
    case FieldType::kU16:
      return use(u16{});
    case FieldType::kI32:
    case FieldType::kCount:
      return use(i32{});
    case FieldType::kI64:
      return use(i64{});
    case FieldType::kU64:
      return use(std::uint64_t{});
    case FieldType::kF32:
      return use(f32{});
    case FieldType::kF64:
      return use(f64{});
    default:
      return use(u32{});  // also times and addresses
  }
}

bool is_variable(const SchemaField& field) {
  return field.repeat == Repeat::kSequence || field.repeat == Repeat::kTail;
}
// Sequences of characters and bytes are told as a whole.
bool is_blob(const SchemaField& field) {
  return is_variable(field) && (field.type == FieldType::kChar || field.type == FieldType::kByte);
}

template <typename T>
MessageValue number_value(T number) {
  if constexpr (std::is_floating_point_v<T>) {
    return {number};
  } else if constexpr (std::is_signed_v<T>) {
    return {std::int64_t{number}};
  } else {
    return {std::uint64_t{number}};
  }
}

template <typename T>
T number_of(const MessageValue& value) {
  return std::visit(
      []<typename Held>(const Held& held) -> T {
        if constexpr (std::is_arithmetic_v<Held>) return static_cast<T>(held);
        return T{};
      },
      value.is);
}

tims::Address address_of(const MessageValue& value) { return tims::Address(number_of<u32>(value)); }
const Values& list_of(const MessageValue& value) { return std::get<Values>(value.is); }
Values& list_of(MessageValue& value) { return std::get<Values>(value.is); }
const std::string& text_of(const MessageValue& value) { return std::get<std::string>(value.is); }

std::size_t elements(const SchemaField& field, const MessageValue& value) {
  return is_blob(field) ? text_of(value).size() : list_of(value).size();
}

// How many elements follow the count at that field.
std::size_t counted(const Schema& schema, const Values& values, std::size_t count) {
  for (std::size_t i = count + 1; i < schema.fields.size(); ++i) {
    if (schema.fields[i].repeat == Repeat::kSequence) return elements(schema.fields[i], values[i]);
  }
  return 0;
}

// --- bytes to values

MessageValue read_struct(const Schema& schema, const std::byte*& from, std::endian order);

MessageValue read_one(const SchemaField& field, const std::byte*& from, std::endian order) {
  if (field.type == FieldType::kStruct) return read_struct(*field.inner, from, order);
  const std::byte* const at = std::exchange(from, from + field.size);
  if (field.type == FieldType::kText) {
    const std::string_view text(reinterpret_cast<const char*>(at), field.size - 1);
    return {std::string(text.substr(0, text.find('\0')))};
  }
  return with_number(field.type, [&](auto number) {
    bytes::read(at, order, number);
    return number_value(number);
  });
}

MessageValue read_many(const SchemaField& field, std::size_t count, const std::byte*& from,
                       std::endian order) {
  if (is_blob(field)) {
    const auto* const text = reinterpret_cast<const char*>(std::exchange(from, from + count));
    return {std::string(text, count)};
  }
  Values list;
  list.reserve(count);
  for (std::size_t i = 0; i < count; ++i) list.push_back(read_one(field, from, order));
  return {std::move(list)};
}

MessageValue read_struct(const Schema& schema, const std::byte*& from, std::endian order) {
  Values values;
  values.reserve(schema.fields.size());
  for (const SchemaField& field : schema.fields)
    values.push_back(field.repeat == Repeat::kArray ? read_many(field, field.times, from, order)
                                                    : read_one(field, from, order));
  return {std::move(values)};
}

// A whole body; whatever lengths it states, nothing behind its end is read.
class Reader {
 public:
  Reader(const Schema& schema, Bytes body, std::endian order)
      : schema_(schema), body_(body), order_(order), from_(body.data()) {}

  Result<MessageValue> run() {
    if (body_.size() < schema_.size_min)
      return codec::too_short(schema_.name, schema_.size_min, body_.size());
    Values values;
    values.reserve(schema_.fields.size());
    for (const SchemaField& field : schema_.fields) {
      auto value = read(field);
      if (!value) return value.error();
      values.push_back(*std::move(value));
    }
    const std::size_t there = body_.size();
    const std::size_t used = there - left();
    if (there != used && there != schema_.whole_size &&
        !(schema_.surplus > 0 && left() == schema_.surplus))
      return codec::surplus(schema_.name, used, there);
    return MessageValue{std::move(values)};
  }

 private:
  [[nodiscard]] std::size_t left() const {
    return body_.size() - static_cast<std::size_t>(from_ - body_.data());
  }

  Result<MessageValue> read(const SchemaField& field) {
    switch (field.repeat) {
      case Repeat::kNot:
        break;
      case Repeat::kArray:
        return read_many(field, field.times, from_, order_);
      case Repeat::kSequence:  // refused by the name of its count, which is what stands on the wire
        return read_elements(field, count_, count_name_.empty() ? field.name : count_name_);
      case Repeat::kTail:
        return read_elements(field, schema_.tail_size(body_, order_, tails_++), field.name);
    }
    MessageValue value = read_one(field, from_, order_);
    if (field.type == FieldType::kCount) {
      count_ = number_of<std::int64_t>(value);
      count_name_ = field.name;
    }
    return value;
  }

  Result<MessageValue> read_elements(const SchemaField& field, std::int64_t count,
                                     std::string_view name) {
    const codec::Place place{schema_.name, name};
    if (count < 0 || count > static_cast<std::int64_t>(field.times))
      return codec::bad_count(place, count, field.times);
    const auto wanted = static_cast<std::size_t>(count);
    if (wanted * field.size > left())
      return codec::elements_missing(place, wanted * field.size, left());
    return read_many(field, wanted, from_, order_);
  }

  const Schema& schema_;
  Bytes body_;
  std::endian order_;
  const std::byte* from_;
  std::int64_t count_ = 0;
  std::string_view count_name_;
  std::size_t tails_ = 0;
};

// --- values to bytes

class Writer {
 public:
  explicit Writer(std::endian order) : order_(order) {}

  Result<std::vector<std::byte>> run(const Schema& schema, const Values& values) {
    std::size_t tails = 0;
    for (std::size_t i = 0; i < schema.fields.size(); ++i) {
      const SchemaField& field = schema.fields[i];
      const codec::Place place{schema.name, field.name};
      if (is_variable(field) && elements(field, values[i]) > field.times)
        return codec::too_many(place, elements(field, values[i]), field.times);
      if (field.repeat == Repeat::kTail) {
        const std::int64_t stated = schema.tail_size(out_, order_, tails++);
        if (std::cmp_not_equal(elements(field, values[i]), stated))
          return codec::wrong_tail(place, elements(field, values[i]), stated);
      }
      if (field.type == FieldType::kCount) {
        put(static_cast<i32>(counted(schema, values, i)));
      } else {
        put(field, values[i]);
      }
    }
    if (schema.pads) out_.resize(std::max(out_.size(), schema.whole_size));
    return std::move(out_);
  }

 private:
  template <typename T>
  void put(T number) {
    std::array<std::byte, sizeof number> sent;
    bytes::write(sent.data(), order_, number);
    out_.insert(out_.end(), sent.begin(), sent.end());
  }

  void put_text(const std::string& text, std::size_t size) {
    const auto* const from = reinterpret_cast<const std::byte*>(text.data());
    out_.insert(out_.end(), from, from + std::min(text.size(), size));
    out_.resize(out_.size() + size - std::min(text.size(), size));
  }

  void put(const SchemaField& field, const MessageValue& value) {
    if (field.repeat == Repeat::kNot) return put_one(field, value);
    if (is_blob(field)) return put_text(text_of(value), text_of(value).size());
    for (const MessageValue& element : list_of(value)) put_one(field, element);
  }

  void put_one(const SchemaField& field, const MessageValue& value) {
    if (field.type == FieldType::kText) return put_text(text_of(value), field.size);
    if (field.type != FieldType::kStruct)
      return with_number(field.type, [&]<typename T>(T) { put(number_of<T>(value)); });
    for (std::size_t i = 0; i < field.inner->fields.size(); ++i)
      put(field.inner->fields[i], list_of(value)[i]);
  }

  std::endian order_;
  std::vector<std::byte> out_;
};

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

void append_hex(std::string& out, std::string_view bytes) {
  out += '"';
  for (const char byte : bytes) {
    const auto value = static_cast<unsigned char>(byte);
    out += kDigits[value >> 4U];
    out += kDigits[value & 0xFU];
  }
  out += '"';
}

void append_leaf(std::string& out, const SchemaField& field, const MessageValue& value,
                 const PrintStyle& style) {
  if (field.type == FieldType::kText) return append_quoted(out, text_of(value));
  if (field.type == FieldType::kAddress)
    return append_quoted(out, address_of(value).to_string(style.widths));
  if (!style.si || field.si == 1) return append_number(out, value);
  // Divided where that is exact: 1001 mm are 1.001 m, and not 1.0009999999999999.
  const auto raw = number_of<f64>(value);
  const f64 si = field.si < 1 ? raw / (1 / field.si) : raw * field.si;
  field.type == FieldType::kF32 ? append(out, static_cast<f32>(si)) : append(out, si);
}

void append_blob(std::string& out, const SchemaField& field, const MessageValue& value,
                 const PrintStyle& style) {
  const auto first = std::string_view(text_of(value)).substr(0, style.elements_max);
  field.type == FieldType::kChar ? append_quoted(out, first) : append_hex(out, first);
}

// Whether JSON has no other word for it than null.
bool is_null(const SchemaField& field, const MessageValue& value) {
  if (field.type == FieldType::kAddress) return address_of(value) == kNobody;
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
    append_json(out, *field.inner, list_of(value), style);
  } else if (is_null(field, value)) {
    out += "null";
  } else {
    append_leaf(out, field, value, style);
  }
}

void append_json_field(std::string& out, const SchemaField& field, const MessageValue& value,
                       const PrintStyle& style) {
  if (field.repeat == Repeat::kNot) return append_json_one(out, field, value, style);
  if (is_blob(field)) return append_blob(out, field, value, style);
  const Values& list = list_of(value);
  const std::size_t size =
      is_variable(field) ? std::min(list.size(), style.elements_max) : list.size();
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

// "x 100 mm, y 0 mm" of an element, and "100 mm" of a single number.
void append_inline(std::string& out, const SchemaField& field, const MessageValue& value,
                   const PrintStyle& style);

void append_inline_one(std::string& out, const SchemaField& field, const MessageValue& value,
                       const PrintStyle& style) {
  if (field.type == FieldType::kAddress) {
    const tims::Address address = address_of(value);
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
      append_inline(out, schema.fields[i], list_of(value)[i], style);
    }
  }
}

void append_inline(std::string& out, const SchemaField& field, const MessageValue& value,
                   const PrintStyle& style) {
  if (field.repeat == Repeat::kNot) return append_inline_one(out, field, value, style);
  const Values& list = list_of(value);
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
      append_text(out, name + ".", *field.inner, list_of(values[i]), style);
      continue;
    }
    if (is_variable(field) && !is_blob(field)) {
      append_text_list(out, name, field, list_of(values[i]), style);
      continue;
    }
    begin_entry(out, name, style);
    if (field.type == FieldType::kCount) {
      append(out, counted(schema, values, i));
    } else if (is_blob(field)) {
      append_blob(out, field, values[i], style);
    } else {
      append_inline(out, field, values[i], style);
    }
    end_entry(out, style);
  }
}

// --- lines of numbers

void append_numbers(std::string& out, const Schema& schema, const Values& values);

void append_word(std::string& out, std::string_view word) {
  if (!out.empty()) out += ' ';
  out += word;
}

void append_numbers_one(std::string& out, const SchemaField& field, const MessageValue& value) {
  if (field.type == FieldType::kStruct) return append_numbers(out, *field.inner, list_of(value));
  std::string word;
  if (field.type == FieldType::kText) {
    append_quoted(word, text_of(value));
  } else if (field.type == FieldType::kF32 || field.type == FieldType::kF64) {
    const bool is_double = field.type == FieldType::kF64;  // places on Earth
    std::array<char, 400> digits;
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), number_of<f64>(value),
                      std::chars_format::fixed, is_double ? 16 : 6)
            .ptr;
    word.assign(digits.data(), end);
  } else {
    append_number(word, value);
  }
  append_word(out, word);
}

void append_numbers(std::string& out, const Schema& schema, const Values& values) {
  for (std::size_t i = 0; i < schema.fields.size(); ++i) {
    const SchemaField& field = schema.fields[i];
    if (field.type == FieldType::kCount) {
      append_word(out, std::to_string(counted(schema, values, i)));
    } else if (is_blob(field)) {
      std::string word;
      append_blob(word, field, values[i], {});
      append_word(out, word);
    } else if (field.repeat == Repeat::kNot) {
      append_numbers_one(out, field, values[i]);
    } else {
      for (const MessageValue& element : list_of(values[i]))
        append_numbers_one(out, field, element);
    }
  }
}

// --- what people write

tims::Error invalid(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

tims::Error no_field(std::string_view type, std::string_view path) {
  std::string text(type);
  text += " has no field ";
  append_quoted(text, path);
  return invalid(std::move(text));
}

tims::Error bad_value(const Assignment& a, std::string_view wanted) {
  return invalid(
      std::string(a.field).append("=").append(a.value).append(": wanted is ").append(wanted));
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

// "pos" of "pos.x" and "points[3]", which leaves ".x" and "[3]".
std::string_view take_name(std::string_view& path) {
  const std::string_view name = path.substr(0, path.find_first_of(".["));
  path.remove_prefix(name.size());
  return name;
}

// All of the text, as a number.
template <typename T>
std::optional<T> number_in(std::string_view text) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// 3 of "[3].x", which leaves ".x".
std::optional<std::size_t> take_index(std::string_view& path) {
  const std::size_t end = path.find(']');
  if (!path.starts_with('[') || end == std::string_view::npos) return std::nullopt;
  const auto index = number_in<std::size_t>(path.substr(1, end - 1));
  path.remove_prefix(end + 1);
  return index;
}

// Pairs of digits; nothing when it is none.
std::optional<std::string> bytes_of(std::string_view digits) {
  std::string out;
  for (; !digits.empty(); digits.remove_prefix(2)) {
    unsigned value = 0;
    if (digits.size() < 2) return std::nullopt;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + 2, value, 16);
    if (error != std::errc() || stop != digits.data() + 2) return std::nullopt;
    out += static_cast<char>(value);
  }
  return out;
}

// "200", "200mm/s", "0.2 m/s": the number, and whether it is one in SI units.
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
  const auto number = number_in<T>(a.value);
  if (!number) return bad_number<T>(a);
  value = number_value(*number);
  return {};
}

template <typename T>
Result<void> set_quantity(const SchemaField& field, MessageValue& value, const Assignment& a,
                          bool si) {
  const auto read = measure(a.value, field, si);
  if (!read) return bad_value(a, "a number in " + std::string(field.unit));
  if (!read->si) return set_number<T>(value, {a.field, read->number});
  const auto number = number_in<f64>(read->number);
  if (!number) return bad_value(a, "a number in " + std::string(field.si_unit));
  const f64 raw = *number / field.si;
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    if (!(raw >= static_cast<f64>(Limits::min()) && raw <= static_cast<f64>(Limits::max())))
      return bad_number<T>(a);
    // The largest i64 is no double; 2^63 is.
    value = number_value(raw >= static_cast<f64>(Limits::max()) ? Limits::max()
                                                                : static_cast<T>(std::round(raw)));
  } else {
    value = number_value(static_cast<T>(raw));
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
    value = number_value(address->raw());
    return {};
  }
  return with_number(field.type, [&]<typename T>(T) -> Result<void> {
    return field.unit.empty() ? set_number<T>(value, a)
                              : set_quantity<T>(field, value, a, style.si);
  });
}

Result<void> set_blob(const SchemaField& field, MessageValue& value, const Assignment& a) {
  auto bytes = field.type == FieldType::kChar ? std::string(a.value) : bytes_of(a.value);
  if (!bytes) return bad_value(a, "pairs of hex digits");
  if (bytes->size() > field.times)
    return bad_value(a, "at most " + std::to_string(field.times) + " bytes");
  value = {*std::move(bytes)};
  return {};
}

MessageValue made_element(const SchemaField& field) {
  if (field.type == FieldType::kStruct) return made_value(*field.inner);
  const std::vector<std::byte> zeros(field.size);
  const std::byte* from = zeros.data();
  return read_one(field, from, std::endian::native);
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
  if (path.empty()) return bad_value(a, "not given as a whole, but field by field");
  return set_in(*field.inner, list_of(value), path.substr(path.starts_with('.') ? 1 : 0), a, style);
}

Result<void> set_element(const SchemaField& field, Values& list, std::string_view path,
                         const Assignment& a, const PrintStyle& style) {
  const auto index = take_index(path);
  const std::size_t behind = is_variable(field) ? list.size() + 1 : list.size();
  if (!index || *index >= std::min(behind, field.times)) {
    const std::size_t last =
        std::min(is_variable(field) ? list.size() : field.times - 1, field.times - 1);
    return invalid(std::string(a.field) + ": an index is wanted, here up to " +
                   std::to_string(last) + "; elements are set in their order");
  }
  if (*index < list.size()) return set_one(field, list[*index], path, a, style);
  MessageValue made = made_element(field);
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
  if (field->type == FieldType::kCount) return bad_value(a, "not given: it is counted");
  if (field->repeat == Repeat::kNot) return set_one(*field, value, path, a, style);
  if (!is_blob(*field)) return set_element(*field, list_of(value), path, a, style);
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
    } else if (is_variable(field)) {
      append_columns_one(out, name + "[]", field);
    } else {
      for (std::size_t i = 0; i < field.times; ++i)
        append_columns_one(out, name + "[" + std::to_string(i) + "]", field);
    }
  }
}

}  // namespace

// --- what others call

Result<MessageValue> read_value(const Schema& schema, Bytes body, std::endian order) {
  return Reader(schema, body, order).run();
}

Result<std::vector<std::byte>> write_value(const Schema& schema, const MessageValue& value,
                                           std::endian order) {
  return Writer(order).run(schema, list_of(value));
}

MessageValue made_value(const Schema& schema) {
  if (schema.made != nullptr) return *read_value(schema, schema.made(), std::endian::little);
  if (!schema.made_bytes.empty())
    return *read_value(schema, schema.made_bytes, std::endian::little);
  const std::vector<std::byte> zeros(schema.size_min);
  return *read_value(schema, zeros, std::endian::little);
}

Result<void> assign(const Schema& schema, MessageValue& value, const Assignment& assignment,
                    const PrintStyle& style) {
  return set_in(schema, list_of(value), assignment.field, assignment, style);
}

std::string to_json(const Schema& schema, const MessageValue& value, const PrintStyle& style) {
  std::string out;
  append_json(out, schema, list_of(value), style);
  return out;
}

std::string to_text(const Schema& schema, const MessageValue& value, const PrintStyle& style) {
  std::string out;
  append_text(out, "", schema, list_of(value), style);
  return out;
}

std::string to_numbers(const Schema& schema, const MessageValue& value) {
  std::string out;
  append_numbers(out, schema, list_of(value));
  return out;
}

std::string_view name(FieldType type) {
  switch (type) {
    case FieldType::kI8:
      return "i8";
    case FieldType::kU8:
      return "u8";
    case FieldType::kI16:
      return "i16";
    case FieldType::kU16:
      return "u16";
    case FieldType::kI32:
      return "i32";
    case FieldType::kU32:
      return "u32";
    case FieldType::kI64:
      return "i64";
    case FieldType::kU64:
      return "u64";
    case FieldType::kF32:
      return "f32";
    case FieldType::kF64:
      return "f64";
    case FieldType::kByte:
      return "byte";
    case FieldType::kTime:
      return "time";
    case FieldType::kAddress:
      return "address";
    case FieldType::kCount:
      return "count";
    case FieldType::kChar:
    case FieldType::kText:
      return "text";
    case FieldType::kStruct:
      break;
  }
  return "struct";
}

std::size_t size_of(FieldType type) {
  if (type == FieldType::kText || type == FieldType::kStruct) return 0;
  return with_number(type, [](auto number) { return sizeof number; });
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
      out.append("\\u00") += kDigits[value >> 4U];
      out += kDigits[value & 0xFU];
    }
  }
  out += '"';
}

Result<std::string> Schema::json(Bytes body, std::endian order, const PrintStyle& style) const {
  const auto value = read_value(*this, body, order);
  if (!value) return value.error();
  return to_json(*this, *value, style);
}

Result<std::string> Schema::text(Bytes body, std::endian order, const PrintStyle& style) const {
  const auto value = read_value(*this, body, order);
  if (!value) return value.error();
  return to_text(*this, *value, style);
}

Result<std::vector<std::byte>> Schema::recode(Bytes body, std::endian from, std::endian to) const {
  const auto value = read_value(*this, body, from);
  if (!value) return value.error();
  return write_value(*this, *value, to);
}

Result<std::vector<std::byte>> Schema::make(std::span<const Assignment> set, std::endian order,
                                            const PrintStyle& style) const {
  MessageValue value = made_value(*this);
  for (const Assignment& field : set)
    if (const auto done = assign(*this, value, field, style); !done) return done.error();
  return write_value(*this, value, order);
}

std::vector<Column> Schema::columns() const {
  std::vector<Column> out;
  append_columns(out, "", *this);
  return out;
}

}  // namespace rack
