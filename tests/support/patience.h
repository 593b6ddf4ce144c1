// How long tests wait, and how often they try.
#pragma once

#include <algorithm>
#include <chrono>

#include "tims/time.h"

namespace tims::test {

// How much longer instrumented code may take. Waits for what ought to happen, and intervals in
// which a program must have answered, are multiplied by it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSlowdown = 3;
#else
inline constexpr int kSlowdown = 1;
#endif

// Long enough for a loaded machine: it is used up only by a test that fails.
inline constexpr Duration kPatience = kSlowdown * std::chrono::seconds(20);
inline constexpr int kPatienceMs = static_cast<int>(kPatience / std::chrono::milliseconds(1));

// Of so many seeds, how many this build tries: what a rare one among them does wrong, the release
// build sees; a sanitizer looks at what each of them does.
constexpr unsigned rounds(unsigned seeds) {
  return kSlowdown == 1 ? seeds : std::max(1U, seeds / 10);
}

}  // namespace tims::test
