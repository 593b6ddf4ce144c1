// Waiting for a condition in a test: with a deadline, and with words for what was missing.
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

// `missing` returns an empty text once all is well, and until then what is still missing.
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
    // Conditions that nobody announces are looked at again and again, less often the longer that
    // takes: what is waited for gets the processor. Where something can be waited for (a line, a
    // message, an exit status), wait for that instead.
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 5 / 4, kPauseMax);
  }
}

template <std::predicate Condition>
testing::AssertionResult eventually(Condition condition, std::string_view what,
                                    Duration limit = kPatience) {
  return eventually([&] { return condition() ? std::string() : "still not: " + std::string(what); },
                    limit);
}

}  // namespace tims::test
