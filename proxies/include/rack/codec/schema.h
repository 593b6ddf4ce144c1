// What a message consists of, as data: names, types and units of its fields in the order of the
// wire. With it any body can be read and written by a program that was never compiled with its
// struct, and told as text (message_text.h).
//
// There are two sources of schemas. kSchema<T> is what the compiler knows of a struct; a message
// file (catalogue.h) holds what another compiler knew. One walk over the schema serves both, so
// that own messages of a component are seen as RACK's are.
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

  [[nodiscard]] bool is_variable() const {
    return repeat == Repeat::kSequence || repeat == Repeat::kTail;
  }
  // Sequences of characters and bytes are told as a whole.
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
  // Lengths of the tails follow from the fields before them: of the tail with that number.
  std::int64_t (*tail_size)(Bytes body, std::endian order, std::size_t tail) = nullptr;
  // As its struct is made, little endian: of this program, or else as a message file has it.
  std::vector<std::byte> (*made)() = nullptr;
  Bytes made_bytes{};
};

// A body by names, as any part of it is: a number or an address, a text or bytes, or a list of the
// fields of a struct or the elements of what repeats.
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
  // 0: it is none.
  template <typename T>
  [[nodiscard]] T number() const {
    return std::visit(
        []<typename Held>(const Held& held) -> T {
          if constexpr (std::is_arithmetic_v<Held>) return static_cast<T>(held);
          return T{};
        },
        is);
  }
  // What is asked for as one of these is one.
  [[nodiscard]] tims::Address address() const { return tims::Address(number<u32>()); }
  [[nodiscard]] const std::string& text() const { return std::get<std::string>(is); }
  [[nodiscard]] const std::vector<MessageValue>& list() const {
    return std::get<std::vector<MessageValue>>(is);
  }
  [[nodiscard]] std::vector<MessageValue>& list() {
    return std::get<std::vector<MessageValue>>(is);
  }
};

// What stands in an address field that names nobody, such as the active pilot when there is none.
inline constexpr tims::Address kNobody{0xFFFFFF00};

// Read and written as decode() and encode() do, with their errors.
Result<MessageValue> read_value(const Schema& schema, std::span<const std::byte> body,
                                std::endian order);
Result<std::vector<std::byte>> write_value(const Schema& schema, const MessageValue& value,
                                           std::endian order);
// Read and written again, in `to`.
Result<std::vector<std::byte>> recode(const Schema& schema, std::span<const std::byte> body,
                                      std::endian from, std::endian to);
// A message as its struct has it before anything is set.
MessageValue made_value(const Schema& schema);
// One element of what repeats.
MessageValue made_value(const SchemaField& field);

// How many elements follow the count at that field of a message with these values.
std::size_t counted(const Schema& schema, const std::vector<MessageValue>& values,
                    std::size_t field);

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

std::string_view name(FieldType type);  // "i32"
// Bytes of a number of this type; 0: of a text or a struct.
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
