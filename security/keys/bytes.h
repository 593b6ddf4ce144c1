// Numbers (least significant byte first) and counted bytes in a byte sequence.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "security/crypto/handles.h"

namespace tims::security {

template <std::unsigned_integral T>
void append(Bytes& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i)));
}
inline void append(Bytes& out, View bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }
// The size as a T, then the bytes.
template <std::unsigned_integral T>
void append_counted(Bytes& out, View bytes) {
  append(out, static_cast<T>(bytes.size()));
  append(out, bytes);
}

// Takes from the front. What is missing makes the whole reader fail: ask ok() at the end.
class Reader {
 public:
  explicit Reader(View bytes) : left_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] View left() const { return left_; }

  View take(std::size_t size) {
    if (size > left_.size()) {
      ok_ = false;
      size = 0;
    }
    const View taken = left_.first(size);
    left_ = left_.subspan(size);
    return taken;
  }
  template <std::unsigned_integral T>
  T number() {
    std::uint64_t value = 0;
    const View taken = take(sizeof(T));
    for (std::size_t i = taken.size(); i-- > 0;)
      value = value << 8 | std::to_integer<std::uint64_t>(taken[i]);
    return static_cast<T>(value);
  }
  template <std::unsigned_integral T>
  View counted() {
    return take(number<T>());
  }

 private:
  View left_;
  bool ok_ = true;
};

}  // namespace tims::security
