// Consumes a fuzzer's bytes from the front; and the check of properties for all targets.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>

namespace tims::fuzz {

// Not assert(), because it must be checked in every build.
inline void require(bool holds) {
  if (!holds) std::abort();
}

// Prevents the compiler from removing the computation of `value`.
template <typename T>
void use(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : left_(data, size) {}

  [[nodiscard]] bool empty() const { return left_.empty(); }
  // Zero after the last byte.
  template <typename T>
  T number() {
    T value{};
    const auto bytes = take(sizeof(T));
    // An empty span may have a null pointer, which memcpy must not get.
    if (!bytes.empty()) std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  std::span<const std::uint8_t> take(std::size_t count) {
    const auto taken = left_.first(std::min(count, left_.size()));
    left_ = left_.subspan(taken.size());
    return taken;
  }
  std::span<const std::byte> rest() { return std::as_bytes(take(left_.size())); }
  std::string_view text() {
    const auto bytes = take(left_.size());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::span<const std::uint8_t> left_;
};

}  // namespace tims::fuzz
