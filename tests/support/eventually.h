// Waits for a condition in a test, up to a deadline; a failure states what was missing.
//
//   EXPECT_TRUE(eventually([&] { return table.size() == 3; }, "three mailboxes in the table"));
//   EXPECT_TRUE(eventually([&] -> std::string {
//     return size() == 3 ? "" : "3 mailboxes expected, found " + std::to_string(size());
//   }));
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <string>
#include <string_view>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/patience.h"
#include "tims/time.h"

namespace tims::test {

// `missing` returns an empty text when the condition is met, and otherwise what is missing.
template <typename Missing>
  requires std::convertible_to<std::invoke_result_t<Missing>, std::string>
testing::AssertionResult eventually(Missing missing, Duration limit = kPatience) {
  using Clock = std::chrono::steady_clock;
  constexpr Duration kPauseMax = std::chrono::milliseconds(50);
  const auto deadline = Clock::now() + limit;
  Duration pause = std::chrono::milliseconds(1);
  for (;;) {
    const bool last_try = Clock::now() >= deadline;
    const std::string text = missing();
    if (text.empty()) return testing::AssertionSuccess();
    if (last_try) {
      const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(limit).count();
      return testing::AssertionFailure() << "after " << ms << " ms: " << text;
    }
    // The condition is polled, less and less often, to leave the processor to the code under test.
    // Where an event can be waited for (a line, a message, an exit status), use that instead.
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 5 / 4, kPauseMax);
  }
}

template <std::predicate Condition>
testing::AssertionResult eventually(Condition condition, std::string_view what,
                                    Duration limit = kPatience) {
  return eventually(
      [&] { return condition() ? std::string() : "condition not met: " + std::string(what); },
      limit);
}

}  // namespace tims::test
