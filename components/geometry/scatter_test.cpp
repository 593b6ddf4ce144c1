#include "components/geometry/scatter.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {
namespace scatter_test {

TEST(Scatter, OfOnePointHasNoSize) {
  Scatter scatter;
  scatter.add(3, -4);
  EXPECT_EQ(scatter.points(), 1);
  EXPECT_DOUBLE_EQ(scatter.mean().x, 3);
  EXPECT_DOUBLE_EQ(scatter.mean().y, -4);
  EXPECT_DOUBLE_EQ(scatter.variances().along, 0);
  EXPECT_DOUBLE_EQ(scatter.variances().beside, 0);
  EXPECT_TRUE(std::isfinite(scatter.direction()));
}

// A rectangle of four points, turned: its sides' halves are what they scatter by.
TEST(Scatter, SeesARectangleInEveryDirection) {
  for (double turn = -1.5; turn <= 1.5; turn += 0.1) {
    Scatter scatter;
    for (const double along : {-30.0, 30.0})
      for (const double beside : {-2.0, 2.0})
        scatter.add(7 + along * std::cos(turn) - beside * std::sin(turn),
                    -5 + along * std::sin(turn) + beside * std::cos(turn));
    EXPECT_NEAR(scatter.mean().x, 7, 1e-9);
    EXPECT_NEAR(scatter.mean().y, -5, 1e-9);
    EXPECT_NEAR(scatter.variances().along, 900, 1e-9);
    EXPECT_NEAR(scatter.variances().beside, 4, 1e-9);
    EXPECT_NEAR(scatter.direction(), turn, 1e-9);
  }
}

// Nothing lies less than nothing beside a line, also where numbers are rounded.
TEST(Scatter, OfALineLiesOnIt) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1000, 1000);
  for (int line = 0; line < 1000; ++line) {
    const double turn = any(random);
    Scatter scatter;
    for (int i = 0; i < 9; ++i) {
      const double at = any(random);
      scatter.add(at * std::cos(turn), at * std::sin(turn));
    }
    EXPECT_GE(scatter.variances().beside, 0);
    EXPECT_LT(scatter.variances().beside, 1e-6);
    EXPECT_NEAR(std::sin(scatter.direction() - turn), 0, 1e-9);
  }
}

}  // namespace scatter_test
}  // namespace rack
