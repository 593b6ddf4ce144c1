// Numbers of the wire with their unit in the type. A quantity converts from and to the number that
// is sent, so `move.vx = 200` means 200 mm/s; .si() and from_si() use metres, seconds, radians.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>

namespace rack {

// Names of the number types as in the tables of the specification.
using i8 = std::int8_t;
using u8 = std::uint8_t;
using i16 = std::int16_t;
using u16 = std::uint16_t;
using i32 = std::int32_t;
using u32 = std::uint32_t;
using i64 = std::int64_t;
using f32 = float;
using f64 = double;

// A unit: its printed name, the name of the SI unit, and its size in that SI unit as a power of
// ten. A new unit is a struct with these three members; without kSiName the unit is an SI unit
// itself.
namespace unit {

template <std::size_t N>
struct Name {
  constexpr Name(const char (&text)[N]) {  // NOLINT(google-explicit-constructor)
    std::copy_n(text, N, characters);
  }
  char characters[N]{};
};

constexpr double power_of_ten(int exponent) {
  double power = 1;
  for (int i = 0; i < (exponent < 0 ? -exponent : exponent); ++i) power *= 10;
  return exponent < 0 ? 1 / power : power;
}

template <Name kText, Name kSiText = kText, int kExponent = 0>
struct Of {
  static constexpr std::string_view kName = kText.characters;
  static constexpr std::string_view kSiName = kSiText.characters;
  static constexpr double kSi = power_of_ten(kExponent);
};

using Millimetre = Of<"mm", "m", -3>;
using MillimetrePerSecond = Of<"mm/s", "m/s", -3>;
using MillimetrePerSecond2 = Of<"mm/s2", "m/s2", -3>;
using PerMillimetre = Of<"1/mm", "1/m", 3>;
using PerMillimetre2 = Of<"1/mm2", "1/m2", 6>;
using Radian = Of<"rad">;
using RadianPerSecond = Of<"rad/s">;
using RadianPerSecond2 = Of<"rad/s2">;
using RadianPerMillimetre = Of<"rad/mm", "rad/m", 3>;
using PerSecond = Of<"1/s">;
using Percent = Of<"%", "1", -2>;
using PercentPerSecond = Of<"%/s", "1/s", -2>;
using PercentPerSecond2 = Of<"%/s2", "1/s2", -2>;
using Millisecond = Of<"ms", "s", -3>;
using Second = Of<"s">;
using Volt = Of<"V">;
using Pixel = Of<"px">;
using BitPerPixel = Of<"bit/px">;
using Byte = Of<"bytes">;
using MillimetrePerCell = Of<"mm/cell", "m/cell", -3>;
using MillimetrePerSpeed = Of<"mm/(mm/s)", "m/(m/s)">;  // a braking distance for each mm/s

}  // namespace unit

template <typename Raw, typename UnitOf>
class Quantity {
 public:
  using Unit = UnitOf;

  constexpr Quantity() = default;
  constexpr Quantity(Raw raw) : raw_(raw) {}       // NOLINT(google-explicit-constructor)
  constexpr operator Raw() const { return raw_; }  // NOLINT(google-explicit-constructor)
  [[nodiscard]] constexpr Raw raw() const { return raw_; }

  [[nodiscard]] constexpr double si() const { return static_cast<double>(raw_) * Unit::kSi; }
  // Integers: rounded to the nearest value; saturates when out of range; NaN becomes 0.
  static Quantity from_si(double value) { return Quantity(to_raw(value / Unit::kSi)); }

 private:
  static Raw to_raw(double value) {
    if constexpr (std::is_floating_point_v<Raw>) {
      return static_cast<Raw>(value);
    } else {
      using Limits = std::numeric_limits<Raw>;
      if (std::isnan(value)) return 0;
      // The largest i64 cannot be represented as a double; 2^63 can.
      if (value >= static_cast<double>(Limits::max())) return Limits::max();
      if (value <= static_cast<double>(Limits::min())) return Limits::min();
      return static_cast<Raw>(std::round(value));
    }
  }

  Raw raw_{};
};

template <typename Raw>
using Millimetres = Quantity<Raw, unit::Millimetre>;
template <typename Raw>
using MillimetresPerSecond = Quantity<Raw, unit::MillimetrePerSecond>;
template <typename Raw>
using MillimetresPerSecond2 = Quantity<Raw, unit::MillimetrePerSecond2>;
template <typename Raw>
using Radians = Quantity<Raw, unit::Radian>;
template <typename Raw>
using RadiansPerSecond = Quantity<Raw, unit::RadianPerSecond>;
template <typename Raw>
using RadiansPerSecond2 = Quantity<Raw, unit::RadianPerSecond2>;
template <typename Raw>
using Percent = Quantity<Raw, unit::Percent>;
template <typename Raw>
using Milliseconds = Quantity<Raw, unit::Millisecond>;
template <typename Raw>
using Seconds = Quantity<Raw, unit::Second>;
template <typename Raw>
using Pixels = Quantity<Raw, unit::Pixel>;

// --- The 32-bit time stamps of messages: milliseconds that wrap to 0 every 49.7 days.

// Comparison and difference are modulo 2^32: they are correct for two stamps less than 24.8 days
// apart, also across a wrap of the counter. The order is not transitive, so do not use stamps as
// keys of a sorted container.
class TimeStamp {
 public:
  constexpr TimeStamp() = default;
  constexpr TimeStamp(std::uint32_t ms) : ms_(ms) {}  // NOLINT(google-explicit-constructor)
  [[nodiscard]] constexpr std::uint32_t raw() const { return ms_; }

  // From a clock that counts from 1970, as the original programs use on Linux.
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
