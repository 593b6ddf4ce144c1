// Errors of a sensor at a time: pseudo-random numbers that depend only on the sensor, the
// measurement and the time, so that the order of queries does not matter. The seed is hashed with
// all of these; drift is a sum of three slow waves whose phases follow from the seed.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/world/core/world.h"

namespace rack::world {

// A separate seed for each use.
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
