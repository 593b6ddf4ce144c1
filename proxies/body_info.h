// Makes the catalogue's description of a message struct. Only for the sources of the catalogue:
// each struct costs compile time.
#pragma once

#include "rack/codec/codec.h"
#include "rack/codec/parse.h"
#include "rack/codec/print.h"
#include "rack/proxies/catalogue.h"

namespace rack {

namespace body_info {

using Bytes = BodyInfo::Bytes;

template <Struct T>
Result<std::string> json(Bytes body, std::endian order, const PrintStyle& style) {
  const auto value = decode<T>(body, order);
  if (!value) return value.error();
  return to_json(*value, style);
}

template <Struct T>
Result<std::string> text(Bytes body, std::endian order, const PrintStyle& style) {
  const auto value = decode<T>(body, order);
  if (!value) return value.error();
  return to_text(*value, style);
}

template <Struct T>
Result<std::vector<std::byte>> recode(Bytes body, std::endian from, std::endian to) {
  const auto value = decode<T>(body, from);
  if (!value) return value.error();
  std::vector<std::byte> bytes(encoded_size(*value));
  if (const auto size = encode(*value, bytes, to); !size) return size.error();
  return bytes;
}

template <Struct T>
Result<std::vector<std::byte>> make(std::span<const Assignment> fields, std::endian order,
                                    const PrintStyle& style) {
  T value{};
  for (const Assignment& field : fields)
    if (const auto set = assign(value, field, style); !set) return set.error();
  std::vector<std::byte> bytes(encoded_size(value));
  if (const auto size = encode(value, bytes, order); !size) return size.error();
  return bytes;
}

template <Struct T>
inline constexpr BodyInfo kInfo = {.name = reflect::kTypeName<T>,
                                   .body_max = body_max<T>(),
                                   .json = json<T>,
                                   .text = text<T>,
                                   .recode = recode<T>,
                                   .make = make<T>,
                                   .columns = columns<T>};

}  // namespace body_info

template <Struct T>
inline constexpr const BodyInfo* kBody = &body_info::kInfo<T>;

}  // namespace rack
