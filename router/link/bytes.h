// Integers in datagrams: little-endian, read and written with bounds. Neither end ever leaves its
// span: a reader that has run out says so once (ok()) and reads zeros.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace tims::link {

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  [[nodiscard]] std::span<const std::byte> rest() const { return rest_; }

  template <std::integral T>
  T get() {
    if (rest_.size() < sizeof(T)) {
      fail();
      return {};
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      value |= std::to_integer<std::uint64_t>(rest_[i]) << (8 * i);
    }
    rest_ = rest_.subspan(sizeof(T));
    return static_cast<T>(value);
  }

  std::span<const std::byte> take(std::size_t size) {
    if (rest_.size() < size) {
      fail();
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  std::string_view text(std::size_t size) {
    const auto bytes = take(size);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as the text they are
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  void fail() {
    ok_ = false;
    rest_ = {};
  }

  std::span<const std::byte> rest_;
  bool ok_ = true;
};

// The caller has seen to it that there is room (room()).
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> to) : to_(to) {}

  [[nodiscard]] std::size_t size() const { return used_; }
  [[nodiscard]] std::size_t room() const { return to_.size() - used_; }
  [[nodiscard]] std::span<std::byte> written() const { return to_.first(used_); }

  template <std::integral T>
  void put(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      to_[used_ + i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF);
    }
    used_ += sizeof(T);
  }
  void put_bytes(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(to_.data() + used_, bytes.data(), bytes.size());
    used_ += bytes.size();
  }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text))); }
  // The next `size` bytes, for somebody else to fill.
  std::span<std::byte> reserve(std::size_t size) {
    used_ += size;
    return to_.subspan(used_ - size, size);
  }

 private:
  std::span<std::byte> to_;
  std::size_t used_ = 0;
};

}  // namespace tims::link
