// How long tests wait.
#pragma once

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

}  // namespace tims::test
