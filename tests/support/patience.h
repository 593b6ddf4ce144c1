// Timeouts of tests, and numbers of repetitions.
#pragma once

#include <algorithm>
#include <chrono>

#include "tims/time.h"

namespace tims::test {

// The factor by which instrumented code may be slower. Timeouts of expected events, and intervals
// within which a program must answer, are multiplied by it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSlowdown = 3;
#else
inline constexpr int kSlowdown = 1;
#endif

// Long enough for a loaded machine; only a failing test waits for so long.
inline constexpr Duration kPatience = kSlowdown * std::chrono::seconds(45);
inline constexpr int kPatienceMs = static_cast<int>(kPatience / std::chrono::milliseconds(1));

// The number of seeds that this build tries: the release build tries all, to find rare failures;
// builds with sanitizers try fewer, because they check every operation of each.
constexpr unsigned rounds(unsigned seeds) {
  return kSlowdown == 1 ? seeds : std::max(1U, seeds / 10);
}

}  // namespace tims::test
