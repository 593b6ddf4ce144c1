// SplitMix64 (Steele, Lea, Flood 2014): a step of a generator whose state is one number, and its
// finaliser, which spreads every bit of a number over all of it.
#pragma once

#include <cstdint>

namespace tims::core {

constexpr std::uint64_t spread(std::uint64_t z) {
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27) * 0x94D049BB133111EBU;
  return z ^ z >> 31;
}

constexpr std::uint64_t next_random(std::uint64_t& state) {
  return spread(state += 0x9E3779B97F4A7C15U);
}

// From 0 to below 1.
constexpr double next_share(std::uint64_t& state) {
  return static_cast<double>(next_random(state) >> 11) * 0x1.0p-53;
}

}  // namespace tims::core
