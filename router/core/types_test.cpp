#include "router/core/types.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace types_test {

TEST(PriorityClasses, EachThresholdBeginsAClass) {
  const PriorityClasses classes{{1, 2, 3, 4, 5, 6, 255}};
  for (std::uint8_t priority = 0; priority < 7; ++priority)
    EXPECT_EQ(classes.of(priority), priority);
  EXPECT_EQ(classes.of(254), 6U);
  EXPECT_EQ(classes.of(255), 7U);
}

// Table III of the paper: chassis, odometry, position and pilot 40, laser and GPS 30, paths 20.
TEST(PriorityClasses, WhatARobotSendsIsApart) {
  const PriorityClasses& classes = kConventionalClasses;
  EXPECT_EQ(classes.of(0), 1U);  // tools
  EXPECT_EQ(classes.of(1), 2U);  // no priority was given
  EXPECT_EQ(classes.of(14), 2U);
  EXPECT_EQ(classes.of(20), 3U);
  EXPECT_EQ(classes.of(30), 4U);
  EXPECT_EQ(classes.of(40), 5U);
  EXPECT_EQ(classes.of(50), 6U);
  EXPECT_EQ(classes.of(99), 6U);
  EXPECT_EQ(classes.of(100), 7U);
  EXPECT_EQ(classes.of(255), 7U);
  // The data task of a component has one less than its command task.
  for (const int priority : {20, 30, 40, 50})
    EXPECT_EQ(classes.of(static_cast<std::uint8_t>(priority - 1)),
              classes.of(static_cast<std::uint8_t>(priority)));
}

TEST(PriorityClasses, TextsAreAloneInTheLowest) {
  const PriorityClasses& classes = kConventionalClasses;
  EXPECT_EQ(classes.of(Header{.priority = 50, .dest = text_sink()}), 0U);
  EXPECT_EQ(classes.of(Header{.priority = 50, .dest = Address(0x01140000)}), 6U);
  for (int priority = 0; priority < 256; ++priority)
    EXPECT_NE(classes.of(static_cast<std::uint8_t>(priority)), 0U);
}

TEST(PriorityClasses, ThresholdsAscend) {
  EXPECT_TRUE(kConventionalClasses.valid());
  EXPECT_FALSE((PriorityClasses{{0, 1, 15, 25, 25, 45, 100}}.valid()));
  EXPECT_FALSE((PriorityClasses{{0, 1, 15, 25, 35, 45, 44}}.valid()));
}

TEST(PriorityClasses, AsText) {
  EXPECT_EQ(kConventionalClasses.to_string(), "0/1/15/25/35/45/100");
}

}  // namespace types_test
}  // namespace tims::core
