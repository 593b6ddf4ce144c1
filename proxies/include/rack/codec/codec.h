// Converts message structs to and from the body of a message, in either byte order. The fields of a
// struct are the only description of the wire format.
//
// In addition to its fields a struct may have
//   tail_sizes()          lengths of its Tail fields (fields.h)
//   kWholeSize            original programs also send it with this length: the whole table of a C
//                         program, used or not. With kPads = true we send this length, too.
//   kSurplus              original programs also append this number of bytes
//   kBodyMax              its largest size, where not all tails can be long at the same time
//
// Lengths in a body are not trusted: the error names the field, and no memory is allocated for
// elements that are not there.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "rack/codec/fields.h"
#include "tims/message.h"
#include "tims/result.h"

// --- Numbers and structs of fixed size in memory and as bytes of either order. The end of the
// bytes is not checked here: the callers have checked it.
namespace rack::bytes {

template <typename T>
constexpr T swapped(T value) {
  if constexpr (sizeof(T) == 1) {
    return value;
  } else if constexpr (sizeof(T) == 2) {
    return std::bit_cast<T>(__builtin_bswap16(std::bit_cast<std::uint16_t>(value)));
  } else if constexpr (sizeof(T) == 4) {
    return std::bit_cast<T>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value)));
  } else {
    return std::bit_cast<T>(__builtin_bswap64(std::bit_cast<std::uint64_t>(value)));
  }
}

// Both return the position after the value.
template <typename T>
const std::byte* read(const std::byte* from, std::endian order, T& value);
template <typename T>
std::byte* write(std::byte* to, std::endian order, const T& value);

template <typename T>
const std::byte* read_as_is(const std::byte* from, std::endian order, T& value) {
  if constexpr (Number<T>) {
    std::memcpy(&value, from, sizeof value);
    if (order != std::endian::native) value = swapped(value);
  } else if constexpr (WrappedNumber<T>) {
    RawOf<T> raw{};
    read(from, order, raw);
    value = T(raw);
  } else if constexpr (kIsText<T>) {
    (void)value.assign({reinterpret_cast<const char*>(from), T::kBytes});
  } else if constexpr (kIsArray<T>) {
    for (auto& element : value) from = read(from, order, element);
    return from;
  } else {
    reflect::all_fields(value, [&](auto& field, auto) {
      from = read(from, order, field);
      return true;
    });
    return from;
  }
  return from + wire_size<T>();
}

template <typename T>
const std::byte* read(const std::byte* from, std::endian order, T& value) {
  if constexpr (is_plain<T>() && !Number<T>) {
    if (order == std::endian::native) {
      std::memcpy(static_cast<void*>(&value), from, sizeof value);
      return from + sizeof value;
    }
  }
  return read_as_is(from, order, value);
}

template <typename T>
std::byte* write_as_is(std::byte* to, std::endian order, const T& value) {
  if constexpr (Number<T>) {
    const T sent = order == std::endian::native ? value : swapped(value);
    std::memcpy(to, &sent, sizeof sent);
  } else if constexpr (WrappedNumber<T>) {
    write(to, order, value.raw());
  } else if constexpr (kIsText<T>) {
    std::memcpy(to, value.bytes().data(), T::kBytes);
  } else if constexpr (kIsArray<T>) {
    for (const auto& element : value) to = write(to, order, element);
    return to;
  } else {
    reflect::all_fields(value, [&](const auto& field, auto) {
      to = write(to, order, field);
      return true;
    });
    return to;
  }
  return to + wire_size<T>();
}

template <typename T>
std::byte* write(std::byte* to, std::endian order, const T& value) {
  if constexpr (is_plain<T>() && !Number<T>) {
    if (order == std::endian::native) {
      std::memcpy(to, &value, sizeof value);
      return to + sizeof value;
    }
  }
  return write_as_is(to, order, value);
}

// All elements of a vector, copied as one block if no bytes have to be swapped.
template <typename T>
const std::byte* read_all(const std::byte* from, std::endian order, std::vector<T>& elements) {
  if constexpr (is_plain<T>()) {
    if (order == std::endian::native || sizeof(T) == 1) {
      const std::size_t size = elements.size() * sizeof(T);
      if (size > 0) std::memcpy(static_cast<void*>(elements.data()), from, size);
      return from + size;
    }
  }
  for (T& element : elements) from = read(from, order, element);
  return from;
}

template <typename T>
std::byte* write_all(std::byte* to, std::endian order, const std::vector<T>& elements) {
  if constexpr (is_plain<T>()) {
    if (order == std::endian::native || sizeof(T) == 1) {
      const std::size_t size = elements.size() * sizeof(T);
      if (size > 0) std::memcpy(to, elements.data(), size);
      return to + size;
    }
  }
  for (const T& element : elements) to = write(to, order, element);
  return to;
}

}  // namespace rack::bytes

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

using tims::Result;

namespace codec {

// The field of a problem; its text is built only for an error.
struct FieldName {
  std::string_view type;
  std::string_view field;
};
tims::Error too_short(std::string_view type, std::size_t needed, std::size_t there);
tims::Error surplus(std::string_view type, std::size_t expected, std::size_t there);
tims::Error bad_count(FieldName field_name, std::int64_t count, std::size_t max);
tims::Error elements_missing(FieldName field_name, std::size_t needed, std::size_t there);
tims::Error too_many(FieldName field_name, std::size_t count, std::size_t max);
tims::Error wrong_tail(FieldName field_name, std::size_t count, std::int64_t stated);
tims::Error buffer_too_small(std::string_view type, std::size_t needed, std::size_t there);

template <typename T>
consteval std::size_t whole_size() {
  if constexpr (requires { T::kWholeSize; }) {
    return T::kWholeSize;
  } else {
    return 0;
  }
}
template <typename T>
consteval std::size_t padded_size() {
  if constexpr (requires { T::kPads; }) {
    return whole_size<T>();
  } else {
    return 0;
  }
}
template <typename T>
constexpr bool surplus_is_known(std::size_t used, std::size_t there) {
  if (there == used || there == whole_size<T>()) return true;
  if constexpr (requires { T::kSurplus; }) return there - used == T::kSurplus;
  return false;
}

// Reads one struct, field by field. `left`: bytes not read yet.
template <typename T>
class Decoder {
  static_assert(variable_fields_last<T>());

 public:
  Decoder(std::span<const std::byte> body, std::endian order) : left_(body), order_(order) {}

  Result<void> run(T& value) {
    const std::size_t size = left_.size();
    if (size < wire_size<T>()) return too_short(reflect::kTypeName<T>, wire_size<T>(), size);
    Result<void> result;
    reflect::all_fields(value, [&](auto& field, auto index) {
      result = this->template read_field<index>(value, field);
      return result.ok();
    });
    if (!result) return result;
    const std::size_t used = size - left_.size();
    if (!surplus_is_known<T>(used, size)) return surplus(reflect::kTypeName<T>, used, size);
    return {};
  }

 private:
  template <std::size_t I, typename Field>
  Result<void> read_field(const T& value, Field& field) {
    if constexpr (kIsCount<Field>) {
      take(bytes::read(left_.data(), order_, count_));
      return {};
    } else if constexpr (kIsSequence<Field>) {
      return read_elements<I>(field, count_, sequence_name<I>());
    } else if constexpr (kIsTail<Field>) {
      return read_elements<I>(field, value.tail_sizes()[tails_before<T, I>()],
                              reflect::kFieldName<T, I>);
    } else {
      take(bytes::read(left_.data(), order_, field));
      return {};
    }
  }

  template <std::size_t I, typename Field>
  Result<void> read_elements(Field& field, std::int64_t count, std::string_view name) {
    const FieldName field_name{reflect::kTypeName<T>, name};
    if (count < 0 || count > static_cast<std::int64_t>(Field::kMax)) {
      return bad_count(field_name, count, Field::kMax);
    }
    const auto elements = static_cast<std::size_t>(count);
    const std::size_t needed = elements * wire_size<typename Field::Element>();
    if (needed > left_.size()) return elements_missing(field_name, needed, left_.size());
    field.resize(elements);
    take(bytes::read_all(left_.data(), order_, field));
    return {};
  }

  // An error in a sequence names its count, which is the field on the wire.
  template <std::size_t I>
  static consteval std::string_view sequence_name() {
    return count_name<I>(std::make_index_sequence<I>());
  }
  template <std::size_t I, std::size_t... J>
  static consteval std::string_view count_name(std::index_sequence<J...>) {
    std::string_view name = reflect::kFieldName<T, I>;
    const auto look = [&]<std::size_t K>() {
      if constexpr (kIsCount<reflect::Field<T, K>>) name = reflect::kFieldName<T, K>;
    };
    (look.template operator()<J>(), ...);
    return name;
  }

  void take(const std::byte* behind) {
    left_ = left_.subspan(static_cast<std::size_t>(behind - left_.data()));
  }

  std::span<const std::byte> left_;
  std::endian order_;
  std::int32_t count_ = 0;
};

template <typename T, std::size_t I, typename Field>
Result<void> check_field(const T& value, const Field& field) {
  if constexpr (kIsVariable<Field>) {
    const FieldName field_name{reflect::kTypeName<T>, reflect::kFieldName<T, I>};
    if (field.size() > Field::kMax) return too_many(field_name, field.size(), Field::kMax);
    if constexpr (kIsTail<Field>) {
      const std::int64_t stated = value.tail_sizes()[tails_before<T, I>()];
      if (std::cmp_not_equal(field.size(), stated))
        return wrong_tail(field_name, field.size(), stated);
    }
  }
  return {};
}

// Checks whether a struct can be sent, before anything is written.
template <typename T>
Result<void> check(const T& value) {
  Result<void> result;
  reflect::all_fields(value, [&](const auto& field, auto index) {
    result = check_field<T, index>(value, field);
    return result.ok();
  });
  return result;
}

template <typename T, std::size_t I, typename Field>
std::byte* write_field(std::byte* to, std::endian order, const T& value, const Field& field) {
  if constexpr (kIsCount<Field>) {
    const auto& sequence = reflect::field_of<sequence_of_count<T, I>()>(value);
    return bytes::write(to, order, static_cast<std::int32_t>(sequence.size()));
  } else if constexpr (kIsVariable<Field>) {
    return bytes::write_all(to, order, field);
  } else {
    return bytes::write(to, order, field);
  }
}

}  // namespace codec

// Number of bytes that encode() will write.
template <Struct T>
std::size_t encoded_size(const T& value) {
  std::size_t size = wire_size<T>();
  reflect::all_fields(value, [&](const auto& field, auto) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (kIsVariable<Field>) size += field.size() * wire_size<typename Field::Element>();
    return true;
  });
  return std::max(size, codec::padded_size<T>());
}

// Writes to the front of `body`; returns the number of bytes. kInvalidArgument: the content of the
// struct cannot be sent; kBufferTooSmall.
template <Struct T>
Result<std::size_t> encode(const T& value, std::span<std::byte> body,
                           std::endian order = std::endian::native) {
  if (const auto good = codec::check(value); !good) return good.error();
  const std::size_t size = encoded_size(value);
  if (size > body.size()) {
    return codec::buffer_too_small(reflect::kTypeName<T>, size, body.size());
  }
  std::byte* to = body.data();
  reflect::all_fields(value, [&](const auto& field, auto index) {
    to = codec::write_field<T, index>(to, order, value, field);
    return true;
  });
  std::fill(to, body.data() + size, std::byte{0});
  return size;
}

// Decodes into an existing object: allocates nothing when its sequences have enough capacity.
// kMalformed; the object then contains the values read before the error.
template <Struct T>
Result<void> decode(std::span<const std::byte> body, std::endian order, T& value) {
  return codec::Decoder<T>(body, order).run(value);
}

template <Struct T>
Result<T> decode(std::span<const std::byte> body, std::endian order = std::endian::native) {
  T value{};
  if (const auto good = decode(body, order, value); !good) return good.error();
  return value;
}

// A message's body, in the byte order that its header states.
template <Struct T>
Result<void> decode(const tims::MessageView& message, T& value) {
  return decode(message.body, message.header.body_order(), value);
}

template <Struct T>
Result<T> decode(const tims::MessageView& message) {
  return decode<T>(message.body, message.header.body_order());
}

// Reserves memory for the longest message: afterwards, decoding into `value` or filling it
// allocates nothing.
template <Struct T>
void reserve_all(T& value) {
  reflect::all_fields(value, [](auto& field, auto) {
    if constexpr (kIsVariable<std::remove_cvref_t<decltype(field)>>) field.reserve_all();
    return true;
  });
}

}  // namespace rack

#pragma GCC visibility pop
