// What a message consists of, as data: names, types and units of its fields in the order of the
// wire. With it any body can be told as JSON or text, made from fields by name, and written in the
// other byte order by a program that was never compiled with its struct.
//
// There are two sources of schemas. kSchema<T> is what the compiler knows of a struct; a message
// file (catalogue.h) holds what another compiler knew. One walk over the schema serves both, so
// that own messages of a component are seen as RACK's are.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rack/codec/codec.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

enum class FieldType : u8 {
  kI8,
  kU8,
  kI16,
  kU16,
  kI32,
  kU32,
  kI64,
  kU64,
  kF32,
  kF64,
  kByte,
  kChar,
  kTime,  // milliseconds that wrap (TimeStamp)
  kAddress,
  kText,   // in a fixed number of bytes
  kCount,  // of the sequence behind it
  kStruct,
};
enum class Repeat : u8 { kNot, kArray, kSequence, kTail };

struct Schema;
struct PrintStyle;
struct Assignment;
struct Column;

struct SchemaField {
  std::string_view name{};
  FieldType type = FieldType::kI32;  // of one element
  Repeat repeat = Repeat::kNot;
  std::size_t times = 1;       // elements: of an array; of a sequence or tail at most
  std::size_t size = 0;        // bytes of one element
  std::string_view unit{};     // "mm"; empty: none
  std::string_view si_unit{};  // "m"
  f64 si = 1;                  // what one unit is in SI units
  const Schema* inner = nullptr;
};

struct Schema {
  using Bytes = std::span<const std::byte>;

  std::string_view name{};  // "ChassisMoveData"
  std::span<const SchemaField> fields{};
  std::size_t size_min = 0;  // bytes, without the elements of sequences and tails
  std::size_t size_max = 0;
  std::size_t whole_size = 0;  // see codec.h; 0: none
  bool pads = false;
  std::size_t surplus = 0;
  // Lengths of the tails follow from the fields before them: of the tail with that number.
  std::int64_t (*tail_size)(Bytes body, std::endian order, std::size_t tail) = nullptr;
  // As its struct is made, little endian: of this program, or else as a message file has it.
  std::vector<std::byte> (*made)() = nullptr;
  Bytes made_bytes{};

  // --- a body of this kind; kMalformed, kInvalidArgument

  // As to_json() and to_text() have it.
  [[nodiscard]] Result<std::string> json(Bytes body, std::endian order,
                                         const PrintStyle& style) const;
  [[nodiscard]] Result<std::string> text(Bytes body, std::endian order,
                                         const PrintStyle& style) const;
  // Read and written again, in `to`.
  [[nodiscard]] Result<std::vector<std::byte>> recode(Bytes body, std::endian from,
                                                      std::endian to) const;
  // Made of fields by name, the others as the struct has them.
  [[nodiscard]] Result<std::vector<std::byte>> make(std::span<const Assignment> set,
                                                    std::endian order,
                                                    const PrintStyle& style) const;
  // In the order of the wire, with the fields of inner structs one by one.
  [[nodiscard]] std::vector<Column> columns() const;
};

// A body by names, as any part of it is: a number or an address, a text or bytes, or a list of the
// fields of a struct or the elements of what repeats.
struct MessageValue {
  std::variant<std::int64_t, std::uint64_t, f32, f64, std::string, std::vector<MessageValue>> is;
};

inline constexpr std::size_t kAllElements = std::numeric_limits<std::size_t>::max();

// What stands in an address field that names nobody, such as the active pilot when there is none.
inline constexpr tims::Address kNobody{0xFFFFFF00};

struct PrintStyle {
  std::size_t elements_max = kAllElements;  // of a sequence, the first ones
  bool si = false;                          // numbers in SI units
  bool one_line = false;                    // of text: "pos.x 100 mm, pos.y 0 mm"
  tims::AddressWidths widths{};
};

// "pos.x" and what it shall be: "100", and with the unit of the wire or SI: "100mm", "0.1m".
struct Assignment {
  std::string_view field;
  std::string_view value;
};

// A number of a message, by the name that to_text() gives it.
struct Column {
  std::string name;          // "pos.x"; of the elements of a sequence "points[].angle"
  std::string_view unit;     // "mm"; empty: none
  std::string_view si_unit;  // "m"
  std::string_view type;     // "i32", "f32", "address", "text"; "count": of the sequence behind it
  bool operator==(const Column&) const = default;
};
// Read and written as decode() and encode() do, with their errors.
Result<MessageValue> read_value(const Schema& schema, std::span<const std::byte> body,
                                std::endian order);
Result<std::vector<std::byte>> write_value(const Schema& schema, const MessageValue& value,
                                           std::endian order);
// A message as its struct has it before anything is set.
MessageValue made_value(const Schema& schema);

// Sets one number, text or address. Numbers without a unit are those of the wire, or with style.si
// in SI units. The elements of a sequence are set in their order: one behind the last makes it
// longer. Fails with kInvalidArgument, and changes nothing then.
Result<void> assign(const Schema& schema, MessageValue& value, const Assignment& assignment,
                    const PrintStyle& style = {});

// One line of JSON. Counts are told like other fields. Addresses and texts are strings, bytes are
// strings of hex digits; numbers that are not finite, and an address that is nobody's, are null.
std::string to_json(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// One line a number ("pos.x: 100 mm"), and one for each element of a sequence.
std::string to_text(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// All numbers, separated by blanks, as recordings have them (specification, section 11); texts in
// quotes.
std::string to_numbers(const Schema& schema, const MessageValue& value);

std::string_view name(FieldType type);  // "i32"
// Bytes of a number of this type; 0: of a text or a struct.
std::size_t size_of(FieldType type);
// In quotes. What is no printable ASCII is escaped: nobody knows the character set.
void append_quoted(std::string& out, std::string_view text);

// --- schemas of structs

namespace schema {

template <Struct T>
constexpr const Schema* of();

// What one unit of the wire is called in SI; others stay as they are.
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
consteval FieldType type_of() {
  if constexpr (kIsCount<T>) {
    return FieldType::kCount;
  } else if constexpr (kIsText<T>) {
    return FieldType::kText;
  } else if constexpr (std::same_as<T, char>) {
    return FieldType::kChar;
  } else if constexpr (std::same_as<T, std::byte>) {
    return FieldType::kByte;
  } else if constexpr (std::same_as<T, tims::Address>) {
    return FieldType::kAddress;
  } else if constexpr (std::same_as<T, TimeStamp>) {
    return FieldType::kTime;
  } else if constexpr (WrappedNumber<T>) {
    return type_of<RawOf<T>>();
  } else if constexpr (std::is_floating_point_v<T>) {
    return sizeof(T) == sizeof(f32) ? FieldType::kF32 : FieldType::kF64;
  } else if constexpr (Number<T>) {
    constexpr auto kOfSize = std::countr_zero(sizeof(T)) * 2;
    return static_cast<FieldType>(kOfSize + (std::is_signed_v<T> ? 0 : 1));
  } else {
    static_assert(Struct<T>, "an array, sequence or tail of arrays");
    return FieldType::kStruct;
  }
}

template <typename T>
constexpr SchemaField element_of(std::string_view name) {
  SchemaField field{.name = name, .type = type_of<T>(), .size = wire_size<T>()};
  if constexpr (std::same_as<T, TimeStamp>) {
    field.unit = unit::Millisecond::kName;
    field.si_unit = unit::Second::kName;
    field.si = unit::Millisecond::kSi;
  } else if constexpr (QuantityLike<T>) {
    field.unit = T::Unit::kName;
    field.si = T::Unit::kSi;
    field.si_unit = si_name(field.unit);
    // A unit of one's own says its name itself.
    if constexpr (requires { T::Unit::kSiName; }) field.si_unit = T::Unit::kSiName;
  } else if constexpr (type_of<T>() == FieldType::kStruct) {
    field.inner = of<T>();
  }
  return field;
}

template <typename T>
constexpr SchemaField field_of(std::string_view name) {
  if constexpr (kIsArray<T>) {
    SchemaField field = element_of<typename T::value_type>(name);
    field.repeat = Repeat::kArray;
    field.times = std::tuple_size_v<T>;
    return field;
  } else if constexpr (kIsVariable<T>) {
    SchemaField field = element_of<typename T::Element>(name);
    field.repeat = kIsTail<T> ? Repeat::kTail : Repeat::kSequence;
    field.times = T::kMax;
    return field;
  } else {
    return element_of<T>(name);
  }
}

template <typename T>
inline constexpr auto kFields = []<std::size_t... I>(std::index_sequence<I...>) {
  return std::array<SchemaField, sizeof...(I)>{
      field_of<reflect::Field<T, I>>(reflect::kFieldName<T, I>)...};
}(std::make_index_sequence<reflect::kFieldCount<T>>());

// The fields of fixed size are enough for it.
template <typename T>
std::int64_t tail_size(std::span<const std::byte> body, std::endian order, std::size_t tail) {
  T value{};
  const std::byte* from = body.data();
  reflect::all_fields(value, [&](auto& field, auto) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (kIsCount<Field>) {
      from += wire_size<Field>();
    } else if constexpr (!kIsVariable<Field>) {
      from = bytes::read(from, order, field);
    }
    return true;
  });
  return value.tail_sizes()[tail];
}

template <typename T>
std::vector<std::byte> made() {
  const T value{};
  std::vector<std::byte> body(encoded_size(value));
  (void)encode(value, body, std::endian::little);
  return body;
}

template <typename T>
constexpr Schema schema_of() {
  Schema schema{.name = reflect::kTypeName<T>,
                .fields = kFields<T>,
                .size_min = wire_size<T>(),
                .size_max = body_max<T>(),
                .whole_size = codec::whole_size<T>(),
                .pads = codec::padded_size<T>() > 0,
                .made = &made<T>};
  if constexpr (requires { T::kSurplus; }) schema.surplus = T::kSurplus;
  if constexpr (requires(const T& value) { value.tail_sizes(); }) schema.tail_size = &tail_size<T>;
  return schema;
}

}  // namespace schema

template <Struct T>
inline constexpr Schema kSchema = schema::schema_of<T>();

template <Struct T>
constexpr const Schema* schema::of() {
  return &kSchema<T>;
}

}  // namespace rack

#pragma GCC visibility pop
