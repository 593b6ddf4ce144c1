// What a sensor's errors are at a time: numbers that look random and follow from who measures what
// and when, so that it does not matter in which order one asks. A seed is stirred with all of that;
// what drifts is a sum of three slow waves whose phases come from the seed.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/world/core/world.h"

namespace rack::world {

// A seed of its own for each use.
inline std::uint64_t stirred(std::uint64_t seed, std::uint64_t with) {
  return Random(seed ^ Random(with).bits()).bits();
}

inline Random noise_of_ray(std::uint64_t seed, tims::Duration age, const RayDirection& ray) {
  const auto direction = std::bit_cast<std::uint64_t>(ray.azimuth) ^
                         std::rotl(std::bit_cast<std::uint64_t>(ray.elevation), 17);
  return Random(stirred(seed ^ direction, static_cast<std::uint64_t>(age.count())));
}

inline Random noise_at(std::uint64_t seed, tims::Duration age) {
  return Random(stirred(seed, static_cast<std::uint64_t>(age.count())));
}

// Standard deviation 1 over long times.
inline double drift(std::uint64_t seed, tims::Duration age) {
  const double seconds = std::chrono::duration<double>(age).count();
  Random random(seed);
  double sum = 0;
  for (const double period : {97.0, 233.0, 611.0}) {
    const double phase = static_cast<double>(random.uniform()) * 2 * kPi;
    sum += std::sin(2 * kPi * seconds / period + phase);
  }
  return sum * std::sqrt(2.0 / 3.0);
}

}  // namespace rack::world
