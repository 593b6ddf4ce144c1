#include "components/perception/box_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"

namespace rack::perception {
namespace box_fit_test {

TEST(BoxFit, FindsTheTurnedBoxOfTwoSides) {
  Random random(3);
  for (int degrees = 0; degrees < 90; degrees += 7) {
    std::vector<MapPoint> points;
    const double c = std::cos(radians(degrees));
    const double s = std::sin(radians(degrees));
    const auto add = [&](double along, double across) {
      along += 10 * static_cast<double>(random.normal());
      across += 10 * static_cast<double>(random.normal());
      points.push_back({5000 + along * c - across * s, 1000 + along * s + across * c});
    };
    for (int i = 0; i <= 40; ++i) add(i * 100, 0);
    for (int i = 0; i <= 18; ++i) add(0, i * 100);
    const Box box = fit_box(points);
    const double off = std::abs(signed_angle(4 * (box.heading - radians(degrees)))) / 4;
    EXPECT_LE(rack::degrees(off), 1.5) << degrees;
    EXPECT_NEAR(std::max(box.length, box.width), 4000, 120);
    EXPECT_NEAR(std::min(box.length, box.width), 1800, 120);
    EXPECT_NEAR(box.centre.x, 5000 + 2000 * c - 900 * s, 80);
  }
}

TEST(BoxFit, OfOnePointAndOfMany) {
  const MapPoint one{7, 8};
  EXPECT_EQ(fit_box({&one, 1}).length, 0);
  const std::vector<MapPoint> same(8000, one);
  EXPECT_EQ(fit_box(same).width, 0);
}

}  // namespace box_fit_test
}  // namespace rack::perception
