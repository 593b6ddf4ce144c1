// Schema: the fields of a message as data, with names, types and units, in the order of the wire.
// With it a program can read and write any body, and print it as text (message_text.h), although it
// was compiled without the struct.
//
// A schema has one of two sources: kSchema<T> is derived from a struct by the compiler; a message
// file (catalogue.h) contains a schema from another build. The same code processes both, so
// messages that a component defines itself are handled like those of RACK.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rack/codec/codec.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
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
  kCount,  // number of elements of the next sequence
  kStruct,
};
enum class Repeat : u8 { kNot, kArray, kSequence, kTail };

struct Schema;

struct SchemaField {
  std::string_view name{};
  FieldType type = FieldType::kI32;  // of one element
  Repeat repeat = Repeat::kNot;
  std::size_t times = 1;       // elements of an array; maximum of a sequence or tail
  std::size_t size = 0;        // bytes of one element
  std::string_view unit{};     // "mm"; empty: none
  std::string_view si_unit{};  // "m"
  f64 si = 1;                  // one unit in SI units
  const Schema* inner = nullptr;

  [[nodiscard]] bool is_variable() const {
    return repeat == Repeat::kSequence || repeat == Repeat::kTail;
  }
  // Sequences of characters and bytes are printed as a whole.
  [[nodiscard]] bool is_blob() const {
    return is_variable() && (type == FieldType::kChar || type == FieldType::kByte);
  }
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
  // Length of the tail with the given index, computed from the fields before it.
  std::int64_t (*tail_size)(Bytes body, std::endian order, std::size_t tail) = nullptr;
  // Default value of the struct, little endian; from this program, or from the message file.
  std::vector<std::byte> (*made)() = nullptr;
  Bytes made_bytes{};
};

// The value of a body or of a part of it: a number or an address, a text or bytes, or a list of the
// fields of a struct or of the elements of an array or sequence.
struct MessageValue {
  std::variant<std::int64_t, std::uint64_t, f32, f64, std::string, std::vector<MessageValue>> is;

  template <typename T>
  static MessageValue of_number(T number) {
    if constexpr (std::is_floating_point_v<T>) {
      return {number};
    } else if constexpr (std::is_signed_v<T>) {
      return {std::int64_t{number}};
    } else {
      return {std::uint64_t{number}};
    }
  }
  // 0 if it is not a number.
  template <typename T>
  [[nodiscard]] T number() const {
    return std::visit(
        []<typename Held>(const Held& held) -> T {
          if constexpr (std::is_arithmetic_v<Held>) return static_cast<T>(held);
          return T{};
        },
        is);
  }
  // Precondition: the value has the requested type.
  [[nodiscard]] tims::Address address() const { return tims::Address(number<u32>()); }
  [[nodiscard]] const std::string& text() const { return std::get<std::string>(is); }
  [[nodiscard]] const std::vector<MessageValue>& list() const {
    return std::get<std::vector<MessageValue>>(is);
  }
  [[nodiscard]] std::vector<MessageValue>& list() {
    return std::get<std::vector<MessageValue>>(is);
  }
};

// Value of an address field that refers to no component, such as the active pilot when there is
// none.
inline constexpr tims::Address kNobody{0xFFFFFF00};

// As decode() and encode(), with the same errors.
Result<MessageValue> read_value(const Schema& schema, std::span<const std::byte> body,
                                std::endian order);
Result<std::vector<std::byte>> write_value(const Schema& schema, const MessageValue& value,
                                           std::endian order);
// Converts a body to the byte order `to`.
Result<std::vector<std::byte>> recode(const Schema& schema, std::span<const std::byte> body,
                                      std::endian from, std::endian to);
// A message with the default values of its struct.
MessageValue made_value(const Schema& schema);
// Default value of one element of an array or sequence.
MessageValue made_value(const SchemaField& field);

// Number of elements that follow the count at the given field, in a message with these values.
std::size_t counted(const Schema& schema, const std::vector<MessageValue>& values,
                    std::size_t field);

// Calls use(T{}) with the number type that represents this field type on the wire.
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

std::string_view name(FieldType type);  // "i32"
// Size of a number of this type; 0 for a text or a struct.
std::size_t size_of(FieldType type);
// --- schemas of structs

namespace schema {

template <Struct T>
constexpr const Schema* of();

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
    field.si_unit = unit::Millisecond::kSiName;
    field.si = unit::Millisecond::kSi;
  } else if constexpr (QuantityLike<T>) {
    field.unit = T::Unit::kName;
    field.si = T::Unit::kSi;
    field.si_unit = field.unit;
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

// The fields of fixed size are sufficient for it.
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
