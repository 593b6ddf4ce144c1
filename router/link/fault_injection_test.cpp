#include "router/link/fault_injection.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace fault_injection_test {

using namespace std::chrono_literals;

TEST(FaultInjector, LosesItsShare) {
  FaultInjector line(1);
  line.set({.loss = 0.3});
  int lost = 0;
  for (int i = 0; i < 10'000; ++i) lost += line.send(Time{1s}, 100).count == 0 ? 1 : 0;
  EXPECT_NEAR(lost, 3000, 150);
}

TEST(FaultInjector, KeepsARateAndAQueue) {
  FaultInjector line(1);
  line.set({.rate = 1'000'000, .queue = 10'000});
  int through = 0;
  Time last{};
  for (int i = 0; i < 100; ++i) {
    const auto copies = line.send(Time{1s}, 1000 - 42);
    through += static_cast<int>(copies.count);
    if (copies.count > 0) last = copies.at[0];
  }
  EXPECT_EQ(through, 11);
  EXPECT_EQ(last, Time{1s} + 11ms);
}

TEST(FaultInjector, CarriesWhatItsMtuAllows) {
  FaultInjector line(1);
  line.set({.mtu = 1200});
  EXPECT_EQ(line.send(Time{1s}, 1200).count, 1U);
  EXPECT_EQ(line.send(Time{1s}, 1201).count, 0U);
  line.set({.blackout = true});
  EXPECT_EQ(line.send(Time{1s}, 1).count, 0U);
}

}  // namespace fault_injection_test
}  // namespace tims::link
