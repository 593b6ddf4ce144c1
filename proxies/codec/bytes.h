// Numbers and structs of fixed size between memory and bytes of either order. Nobody looks at the
// end of the bytes here: callers have made sure.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "proxies/codec/layout.h"

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

// Both return the place behind the value.
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

// All elements of a vector, at once where nothing is to be swapped.
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
