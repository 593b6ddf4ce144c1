#include "components/perception/track.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "components/localisation/random.h"

namespace rack::perception {
namespace {

Sighting sighting(double x, double y) {
  return {.box = {.centre = {x, y}, .length = 300, .width = 150},
          .deviation = 60,
          .moved = 1,
          .person = true,
          .pair = true};
}

// A walk with the accelerations and the noise that the filter believes in: how far it is off, in
// standard deviations, is what chance allows (normalised estimation error squared, 2 axes).
TEST(Track, ItsDeviationsAreHonest) {
  localisation::Random random(5);
  double place = 0;
  double speed = 0;
  int count = 0;
  for (int run = 0; run < 50; ++run) {
    std::array<double, 2> at{};
    std::array<double, 2> v{};
    Track track(1,
                sighting(60 * static_cast<double>(random.normal()),
                         60 * static_cast<double>(random.normal())),
                0);
    for (int i = 1; i <= 100; ++i) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double a = 800 * std::sqrt(10.0) * static_cast<double>(random.normal());
        at[axis] += v[axis] * 0.1 + a * 0.005;
        v[axis] += a * 0.1;
      }
      track.predict(i * 0.1);
      track.update(sighting(at[0] + 60 * static_cast<double>(random.normal()),
                            at[1] + 60 * static_cast<double>(random.normal())));
      if (i < 20) continue;
      const auto squared = [](double x, double y, double deviation) {
        return (x * x + y * y) / (2 * deviation * deviation);
      };
      place += squared(track.at().x - at[0], track.at().y - at[1], track.deviation());
      speed +=
          squared(track.velocity().x - v[0], track.velocity().y - v[1], track.speed_deviation());
      ++count;
    }
  }
  EXPECT_NEAR(place / count, 1, 0.15);
  EXPECT_NEAR(speed / count, 1, 0.2);
}

TEST(Track, ThreeOfFiveConfirm) {
  Track track(1, sighting(0, 0), 0);
  EXPECT_FALSE(track.confirmed());
  track.predict(0.1);
  track.miss();
  track.predict(0.2);
  track.update(sighting(0, 0));
  EXPECT_FALSE(track.confirmed());
  track.predict(0.3);
  track.update(sighting(0, 0));
  EXPECT_TRUE(track.confirmed());
  track.predict(1.25);
  track.miss();
  EXPECT_FALSE(track.lost());
  track.predict(1.35);
  track.miss();
  EXPECT_TRUE(track.lost());
}

TEST(Track, AVanKeepsItsMiddleWhenOneSideIsSeen) {
  const auto seen = [](double from, double to, double x) {
    return Sighting{
        .box = {.centre = {x + (from + to) / 2, 3000}, .length = to - from, .width = 100},
        .deviation = 100,
        .moved = 1,
        .scanner = {0, 0}};
  };
  Track track(1, seen(-2500, 2500, 8000), 0);
  for (int i = 1; i < 30; ++i) {
    track.predict(i * 0.1);
    // It drives away at 5 m/s; after a second only its rear 2 m are seen.
    track.update(i < 10 ? seen(-2500, 2500, 8000 + i * 500.0)
                        : seen(-2500, -500, 8000 + i * 500.0));
  }
  EXPECT_NEAR(track.at().x, 8000 + 29 * 500, 500);
  EXPECT_NEAR(track.velocity().x, 5000, 500);
  EXPECT_TRUE(track.moving());
  EXPECT_EQ(track.kind(), ObjectKind::kCar);
}

}  // namespace
}  // namespace rack::perception
