#include "components/geometry/pose.h"

#include <limits>

#include <gtest/gtest.h>

namespace rack {

namespace pose_test {

TEST(Angle, IsNormalised) {
  EXPECT_DOUBLE_EQ(heading(-kPi / 2), 1.5 * kPi);
  EXPECT_DOUBLE_EQ(heading(5 * kPi), kPi);
  EXPECT_EQ(heading(2 * kPi), 0);
  EXPECT_LT(heading(-1e-20), 2 * kPi);
  EXPECT_EQ(heading(std::numeric_limits<double>::infinity()), 0);
  EXPECT_DOUBLE_EQ(signed_angle(1.5 * kPi), -kPi / 2);
  EXPECT_DOUBLE_EQ(signed_angle(-kPi), kPi);
}

TEST(Pose, IsRoundedForMessages) {
  const Pose pose{.x = 1.6, .y = -1.6, .z = 1e20, .phi = -0.5, .rho = -kPi / 2};
  const Position3d position = pose.position();
  EXPECT_EQ(position.x, 2);
  EXPECT_EQ(position.y, -2);
  EXPECT_EQ(position.z, std::numeric_limits<i32>::max());
  EXPECT_FLOAT_EQ(position.phi, -0.5F);
  EXPECT_FLOAT_EQ(position.rho, static_cast<float>(1.5 * kPi));
}

TEST(Pose, OfAFrameThatLooksEast) {
  const Pose frame{.x = 1000, .y = 2000, .z = 5, .rho = kPi / 2};
  const Pose world = frame + Pose{.x = 100, .y = 10, .z = 1, .rho = kPi};
  EXPECT_NEAR(world.x, 990, 1e-9);
  EXPECT_NEAR(world.y, 2100, 1e-9);
  EXPECT_EQ(world.z, 6);
  EXPECT_NEAR(world.rho, 1.5 * kPi, 1e-9);
}

TEST(Pose, AShortMovementLooksToTheMiddleOfItsTurn) {
  const Pose to = moved({.x = 10, .z = 5, .rho = 7}, {.x = 3, .y = 4, .rho = 2});
  EXPECT_DOUBLE_EQ(to.x, 10 + 3 * std::cos(8) - 4 * std::sin(8));
  EXPECT_DOUBLE_EQ(to.y, 3 * std::sin(8) + 4 * std::cos(8));
  EXPECT_EQ(to.z, 5);
  EXPECT_EQ(to.rho, 9) << "with its full turn";
}

TEST(Pose, DifferenceUndoesTheSum) {
  const Pose frame{.x = 1000, .y = -2000, .z = 5, .phi = 0.1, .psi = 0.2, .rho = 4};
  const Pose local{.x = -30, .y = 77, .z = 1, .phi = 0.3, .psi = -0.2, .rho = 6};
  const Pose again = (frame + local) - frame;
  EXPECT_NEAR(again.x, local.x, 1e-9);
  EXPECT_NEAR(again.y, local.y, 1e-9);
  EXPECT_NEAR(again.z, local.z, 1e-9);
  EXPECT_NEAR(again.phi, local.phi, 1e-9);
  EXPECT_NEAR(again.psi, local.psi, 1e-9);
  EXPECT_NEAR(again.rho, local.rho, 1e-9);
}

TEST(Pose, InterpolationTurnsByTheSmallerAngle) {
  const Pose middle = between({.x = 0, .rho = radians(350)}, {.x = 10, .rho = radians(20)}, 0.5);
  EXPECT_DOUBLE_EQ(middle.x, 5);
  EXPECT_NEAR(middle.rho, radians(5), 1e-9);
  EXPECT_NEAR(between({.x = 0}, {.x = 10}, 1.5).x, 15, 1e-9);
}

}  // namespace pose_test

}  // namespace rack
