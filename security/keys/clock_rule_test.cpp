#include "security/keys/clock_rule.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace tims::security::clock_rule_test {

constexpr std::int64_t kPassed = 1'800'000'000;

TEST(ClockRule, DatesCountOnlyWithAClockThatCanBeRight) {
  EXPECT_EQ(check_time({.system = 0, .synchronised = true, .passed = kPassed}),
            (CheckTime{kPassed, false}));
  EXPECT_EQ(check_time({.system = kPassed - 1, .synchronised = true, .passed = kPassed}),
            (CheckTime{kPassed, false}));
  EXPECT_EQ(check_time({.system = kPassed, .synchronised = true, .passed = kPassed}),
            (CheckTime{kPassed, true}));
  EXPECT_EQ(check_time({.system = kPassed + 9, .synchronised = false, .passed = kPassed}),
            (CheckTime{kPassed + 9, false}));
}

TEST(ClockRule, ValidityAtItsLimits) {
  const auto at = [](std::int64_t now) { return validity({now, true}, 1000, 2000); };
  EXPECT_EQ(at(999), Validity::kNotYet);
  EXPECT_EQ(at(1000), Validity::kValid);
  EXPECT_EQ(at(1900), Validity::kValid);
  EXPECT_EQ(at(1901), Validity::kEnding);
  EXPECT_EQ(at(2000), Validity::kEnding);
  EXPECT_EQ(at(2001), Validity::kExpired);
  EXPECT_EQ(validity({0, false}, 1000, 2000), Validity::kUnchecked);
  EXPECT_EQ(validity({0, true}, std::numeric_limits<std::int64_t>::min(),
                     std::numeric_limits<std::int64_t>::max()),
            Validity::kValid);
}

TEST(ClockRule, RenewalAtHalfOfTheLife) {
  EXPECT_FALSE(is_renewal_due({1500, true}, 1000, 2000));
  EXPECT_TRUE(is_renewal_due({1501, true}, 1000, 2000));
  EXPECT_TRUE(is_renewal_due({5000, true}, 1000, 2000)) << "also after its end";
  EXPECT_FALSE(is_renewal_due({1501, false}, 1000, 2000));
}

TEST(ClockRule, TheSystemsClockIsNotBeforeWhatHasPassed) {
  constexpr std::int64_t kFarAhead = 9'000'000'000;
  EXPECT_EQ(system_check_time(kFarAhead), (CheckTime{kFarAhead, false}));
  EXPECT_GT(system_check_time(0).now, kPassed - 100'000'000);
}

}  // namespace tims::security::clock_rule_test
