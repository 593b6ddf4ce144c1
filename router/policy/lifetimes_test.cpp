#include "router/policy/lifetimes.h"

#include <gtest/gtest.h>

namespace tims::policy::lifetimes_test {

using namespace std::chrono_literals;

constexpr Address kChassis{0x03110000};
constexpr Address kPilot{0x03180000};

Header header(std::int8_t type, Address dest) { return {.type = type, .dest = dest}; }

TEST(Lifetimes, TheFirstThatMatchesHolds) {
  Lifetimes lifetimes;
  EXPECT_TRUE(lifetimes.add("chassis.move 150ms"));
  EXPECT_TRUE(lifetimes.add(" commands  2s "));
  EXPECT_EQ(lifetimes.of(header(21, kChassis)), 150ms);
  EXPECT_EQ(lifetimes.of(header(21, kPilot)), 2s);
  EXPECT_EQ(lifetimes.of(header(-6, kChassis)), Lifetimes::kForever);
  EXPECT_EQ(Lifetimes().of(header(21, kChassis)), Lifetimes::kForever);
}

TEST(Lifetimes, MistakesAreRefused) {
  Lifetimes lifetimes;
  for (const char* text : {"", "chassis.move", "150ms", "chassis.mov 150ms", "chassis.move x",
                           "chassis.move 19ms", "chassis.move 601s", "chassis.move 1s 2s"})
    EXPECT_FALSE(lifetimes.add(text)) << text;
  EXPECT_TRUE(lifetimes.add("chassis.move 20ms"));
  EXPECT_TRUE(lifetimes.add("chassis.move 10min"));
  for (std::size_t i = 2; i < Lifetimes::kMost; ++i) EXPECT_TRUE(lifetimes.add("off 1s"));
  EXPECT_FALSE(lifetimes.add("off 1s")) << "too many";
}

}  // namespace tims::policy::lifetimes_test
