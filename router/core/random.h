// SplitMix64 (Steele, Lea, Flood 2014): one step of a generator with a 64-bit state, and its
// finaliser, which spreads every input bit over the whole result. Its output is predictable: one
// number reveals all others. Where values must not be predictable, use SipHash-2-4 (Aumasson,
// Bernstein 2012), a hash with a secret key.
#pragma once

#include <bit>
#include <cstdint>
#include <initializer_list>

namespace tims::core {

constexpr std::uint64_t spread(std::uint64_t z) {
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27) * 0x94D049BB133111EBU;
  return z ^ z >> 31;
}

constexpr std::uint64_t next_random(std::uint64_t& state) {
  return spread(state += 0x9E3779B97F4A7C15U);
}

// Uniform in [0, 1).
constexpr double next_share(std::uint64_t& state) {
  return static_cast<double>(next_random(state) >> 11) * 0x1.0p-53;
}

struct SipKey {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
};

// Hash of the bytes of the given 64-bit integers, least significant byte first.
constexpr std::uint64_t sip_hash(const SipKey& key, std::initializer_list<std::uint64_t> words) {
  std::uint64_t v0 = key.low ^ 0x736F6D6570736575U;
  std::uint64_t v1 = key.high ^ 0x646F72616E646F6DU;
  std::uint64_t v2 = key.low ^ 0x6C7967656E657261U;
  std::uint64_t v3 = key.high ^ 0x7465646279746573U;
  const auto rounds = [&](int count) {
    for (; count > 0; --count) {
      v0 += v1;
      v2 += v3;
      v1 = std::rotl(v1, 13) ^ v0;
      v3 = std::rotl(v3, 16) ^ v2;
      v0 = std::rotl(v0, 32);
      v2 += v1;
      v0 += v3;
      v1 = std::rotl(v1, 17) ^ v2;
      v3 = std::rotl(v3, 21) ^ v0;
      v2 = std::rotl(v2, 32);
    }
  };
  const auto take = [&](std::uint64_t word) {
    v3 ^= word;
    rounds(2);
    v0 ^= word;
  };
  for (const std::uint64_t word : words) take(word);
  take(std::uint64_t{words.size() * 8} << 56);
  v2 ^= 0xFF;
  rounds(4);
  return v0 ^ v1 ^ v2 ^ v3;
}
// Test vector published by the authors.
static_assert(sip_hash({0x0706050403020100, 0x0F0E0D0C0B0A0908}, {0x0706050403020100}) ==
              0x93F5F5799A932462);

}  // namespace tims::core
