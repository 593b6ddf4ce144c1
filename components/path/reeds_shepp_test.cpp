#include "components/path/reeds_shepp.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/patience.h"

namespace rack::path {
namespace reeds_shepp_test {

Pose any_pose(std::mt19937& random, double width) {
  std::uniform_real_distribution<double> place(-width, width);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  return {.x = place(random), .y = place(random), .rho = angle(random)};
}

TEST(ReedsShepp, LeadsToWhereItShall) {
  std::mt19937 random(1);
  for (unsigned i = 0; i < tims::test::rounds(100000); ++i) {
    const double width = i % 3 == 0 ? 1000 : 20000;
    const Pose from = any_pose(random, width);
    const Pose to = any_pose(random, width);
    const ReedsShepp curve(from, to, 3000);
    Pose at = from;
    double length = 0;
    for (const Piece& piece : curve.pieces()) {
      at = driven(at, piece);
      length += std::abs(piece.length);
      ASSERT_LE(std::abs(piece.curvature), 1 / 3000.0 + 1e-12);
    }
    ASSERT_NEAR(at.x, to.x, 0.01) << i;
    ASSERT_NEAR(at.y, to.y, 0.01) << i;
    ASSERT_NEAR(signed_angle(at.rho - to.rho), 0, 1e-6) << i;
    ASSERT_NEAR(length, curve.length(), 0.01);
  }
}

// Shortest paths are no longer than any detour, and as long from the other end.
TEST(ReedsShepp, IsTheShortest) {
  std::mt19937 random(2);
  for (unsigned i = 0; i < tims::test::rounds(100000); ++i) {
    const double width = i % 2 == 0 ? 2000 : 15000;
    const Pose a = any_pose(random, width);
    const Pose b = any_pose(random, width);
    const Pose c = any_pose(random, width);
    const double whole = ReedsShepp(a, c, 3000).length();
    ASSERT_LE(whole, ReedsShepp(a, b, 3000).length() + ReedsShepp(b, c, 3000).length() + 0.01);
    ASSERT_GE(whole, std::hypot(a.x - c.x, a.y - c.y) - 0.01);
    ASSERT_NEAR(whole, ReedsShepp(c, a, 3000).length(), 0.01) << i;
  }
}

TEST(ReedsShepp, FindsKnownLengths) {
  EXPECT_NEAR(ReedsShepp({}, {.x = 5000}, 1000).length(), 5000, 0.01);
  EXPECT_NEAR(ReedsShepp({}, {.x = -5000}, 1000).length(), 5000, 0.01);
  EXPECT_NEAR(ReedsShepp({}, {.rho = kPi}, 1000).length(), 1000 * kPi, 0.01)
      << "in three moves of 60 degrees";
  EXPECT_NEAR(ReedsShepp({}, {.x = 1000, .y = 1000, .rho = kPi / 2}, 1000).length(), 1000 * kPi / 2,
              0.01);
}

}  // namespace reeds_shepp_test
}  // namespace rack::path
