// The not yet decoded end of a stream as one contiguous block, with the time of each byte on the
// line.
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "rack/devices/dialogue.h"

namespace rack::device {

class StreamBuffer {
 public:
  // capacity: bytes, more than the longest telegram. When it is exceeded, the oldest bytes are
  // dropped.
  explicit StreamBuffer(std::size_t capacity) : bytes_(2 * capacity), capacity_(capacity) {}

  void add(const Arrival& arrival) {
    if (arrival.bytes.empty()) return;
    std::span<const std::byte> bytes = arrival.bytes;
    if (bytes.size() > capacity_) bytes = bytes.last(capacity_);
    if (size() + bytes.size() > capacity_) consume(size() + bytes.size() - capacity_);
    if (end_ + bytes.size() > bytes_.size()) {
      std::memmove(bytes_.data(), bytes_.data() + begin_, size());
      end_ = size();
      begin_ = 0;
    }
    if (!bytes.empty()) std::memcpy(bytes_.data() + end_, bytes.data(), bytes.size());
    end_ += bytes.size();
    last_ = arrival.last;
    of_byte_ = (arrival.last - arrival.first) / static_cast<std::int64_t>(arrival.bytes.size());
  }

  [[nodiscard]] std::span<const std::byte> bytes() const {
    return std::span(bytes_).subspan(begin_, size());
  }
  [[nodiscard]] std::size_t size() const { return end_ - begin_; }
  void consume(std::size_t count) { begin_ += std::min(count, size()); }
  void clear() { begin_ = end_ = 0; }

  // When the transmission of the byte at `index` of bytes() began.
  [[nodiscard]] Time time_of(std::size_t index) const {
    return last_ - of_byte_ * static_cast<std::int64_t>(size() - std::min(index, size()));
  }

 private:
  std::vector<std::byte> bytes_;
  std::size_t capacity_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  Time last_{};
  Duration of_byte_{};
};

// Reads a number of a telegram. The caller must check the size first.
template <typename Number>
Number little_endian(std::span<const std::byte> bytes, std::size_t at = 0) {
  std::make_unsigned_t<Number> number = 0;
  for (std::size_t i = sizeof(Number); i-- > 0;)
    number = static_cast<std::make_unsigned_t<Number>>(number << 7 << 1) |
             std::to_integer<std::make_unsigned_t<Number>>(bytes[at + i]);
  return static_cast<Number>(number);
}
template <typename Number>
Number big_endian(std::span<const std::byte> bytes, std::size_t at = 0) {
  std::make_unsigned_t<Number> number = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    number = static_cast<std::make_unsigned_t<Number>>(number << 7 << 1) |
             std::to_integer<std::make_unsigned_t<Number>>(bytes[at + i]);
  return static_cast<Number>(number);
}

// Append the `size` lowest bytes of a number to a telegram.
template <typename Number>
void append_little(std::vector<std::byte>& out, Number number, std::size_t size = sizeof(Number)) {
  for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::byte>(number >> (8 * i)));
}
template <typename Number>
void append_big(std::vector<std::byte>& out, Number number, std::size_t size = sizeof(Number)) {
  for (std::size_t i = size; i-- > 0;) out.push_back(static_cast<std::byte>(number >> (8 * i)));
}

// A byte of a telegram, 0 to 255.
inline int byte_at(std::span<const std::byte> bytes, std::size_t index) {
  return std::to_integer<int>(bytes[index]);
}

}  // namespace rack::device
