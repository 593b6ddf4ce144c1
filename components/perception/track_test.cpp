#include "components/perception/track.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "components/perception/room_fixture.h"

namespace rack::perception {
namespace track_test {

Sighting sighting(double x, double y) {
  return {.box = {.centre = {x, y}, .length = 300, .width = 150},
          .deviation = 60,
          .moved = 1,
          .person = true,
          .pair = true,
          .point = {x, y}};
}

// A scanner in an empty field.
FreeTable empty_field() {
  Scan2dData scan{.maxRange = 30000};
  for (int i = 0; i < 720; ++i)
    scan.points.push_back({.x = whole_millimetres(30000 * std::cos(radians(i * 0.5))),
                           .y = whole_millimetres(30000 * std::sin(radians(i * 0.5))),
                           .type = scan_point::kInvalid | scan_point::kMaxRange});
  return table_of(scan);
}

// A walk with the accelerations and the noise that the filter believes in: how far it is off, in
// standard deviations, is what chance allows (normalised estimation error squared, 2 axes).
TEST(Track, ItsDeviationsAreHonest) {
  Random random(5);
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
  track.miss(false);
  track.predict(0.2);
  track.update(sighting(0, 0));
  EXPECT_FALSE(track.confirmed());
  track.predict(0.3);
  track.update(sighting(0, 0));
  EXPECT_TRUE(track.confirmed());
  track.predict(1.25);
  track.miss(false);
  EXPECT_FALSE(track.lost());
  track.predict(1.35);
  track.miss(false);
  EXPECT_TRUE(track.lost());
}

TEST(Track, AnObjectThatIsNotAtItsPlaceIsGone) {
  for (const bool through : {false, true}) {
    Track track(1, sighting(0, 0), 0);
    for (int i = 1; i < 5; ++i) {
      track.predict(i * 0.1);
      track.update(sighting(0, 0));
    }
    for (int i = 5; i < 10; ++i) {
      track.predict(i * 0.1);
      track.miss(through);
    }
    EXPECT_EQ(track.lost(), through);
    EXPECT_TRUE(track.published()) << "until half a second later";
    track.predict(1);
    track.miss(through);
    EXPECT_FALSE(track.published());
  }
}

TEST(Track, AVanKeepsItsMiddleWhenOneSideIsSeen) {
  const auto seen = [](double from, double to, double x) {
    return Sighting{
        .box = {.centre = {x + (from + to) / 2, 3000}, .length = to - from, .width = 100},
        .deviation = 100,
        .moved = 1,
        .point = {x + (from + to) / 2, 3000},
        .scanner = {0, 0}};
  };
  const FreeTable field = empty_field();
  Track track(1, seen(-2500, 2500, 8000), 0);
  for (int i = 1; i < 30; ++i) {
    track.predict(i * 0.1);
    track.look_back(field);
    // It drives away at 5 m/s; after a second only its rear 2 m are seen.
    track.update(i < 10 ? seen(-2500, 2500, 8000 + i * 500.0)
                        : seen(-2500, -500, 8000 + i * 500.0));
  }
  EXPECT_NEAR(track.at().x, 8000 + 29 * 500, 500);
  EXPECT_NEAR(track.velocity().x, 5000, 500);
  EXPECT_TRUE(track.moving());
  EXPECT_EQ(track.kind(), ObjectKind::kCar);
}

}  // namespace track_test
}  // namespace rack::perception
