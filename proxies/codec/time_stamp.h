// The 32-bit time stamps of messages: milliseconds that start again at 0 every 49.7 days.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>

namespace rack {

// Comparison and difference go the short way round: they are right for two stamps less than
// 24.8 days apart, also when the counter wrapped between them. So no sorting key for a container.
class TimeStamp {
 public:
  constexpr TimeStamp() = default;
  constexpr TimeStamp(std::uint32_t ms) : ms_(ms) {}  // NOLINT(google-explicit-constructor)
  [[nodiscard]] constexpr std::uint32_t raw() const { return ms_; }

  // Of a clock that counts from 1970, as the originals on Linux have it.
  static constexpr TimeStamp of(std::chrono::milliseconds since_1970) {
    return static_cast<std::uint32_t>(since_1970.count());
  }

  friend constexpr std::chrono::milliseconds operator-(TimeStamp a, TimeStamp b) {
    return std::chrono::milliseconds(static_cast<std::int32_t>(a.ms_ - b.ms_));
  }
  friend constexpr TimeStamp operator+(TimeStamp t, std::chrono::milliseconds later) {
    return t.ms_ + static_cast<std::uint32_t>(later.count());
  }
  friend constexpr TimeStamp operator-(TimeStamp t, std::chrono::milliseconds earlier) {
    return t.ms_ - static_cast<std::uint32_t>(earlier.count());
  }
  friend constexpr bool operator==(TimeStamp, TimeStamp) = default;
  friend constexpr auto operator<=>(TimeStamp a, TimeStamp b) {
    return static_cast<std::int32_t>(a.ms_ - b.ms_) <=> 0;
  }

 private:
  std::uint32_t ms_ = 0;
};

}  // namespace rack
