// A pseudo-random generator with the same sequence for the same seed on every machine (the
// distributions of the standard library differ between implementations). Pure.
//
// The generator is SplitMix64 (Steele, Lea, Flood 2014): a hashed counter. Approximately normal
// numbers are the sum of four uniform 16-bit numbers of one draw: limited to 3.5 standard
// deviations, and without a logarithm.
#pragma once

#include <cstdint>

namespace rack {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ z >> 30U) * 0xBF58476D1CE4E5B9U;
    z = (z ^ z >> 27U) * 0x94D049BB133111EBU;
    return z ^ z >> 31U;
  }
  // 0 to 1, the latter excluded.
  float uniform() { return static_cast<float>(bits() >> 40U) * 0x1p-24F; }
  float uniform(float from, float to) { return from + (to - from) * uniform(); }
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((bits() >> 32U) * count >> 32U);
  }
  // Mean 0, standard deviation 1.
  float normal() {
    const std::uint64_t b = bits();
    const auto sum = static_cast<float>((b & 0xFFFFU) + (b >> 16U & 0xFFFFU) +
                                        (b >> 32U & 0xFFFFU) + (b >> 48U));
    constexpr float kMean = 2 * 65535.0F;
    constexpr float kDeviation = 37836.9F;  // sqrt(4 / 12) * 65536
    return (sum - kMean) / kDeviation;
  }

 private:
  std::uint64_t state_;
};

}  // namespace rack
