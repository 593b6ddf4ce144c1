// How far poses can be wrong, by what was driven since.
#include "components/mapping/uncertainty.h"

#include <gtest/gtest.h>

namespace rack::mapping {

namespace uncertainty_test {

// A straight drive, a keyframe every half metre.
Track straight(double length) {
  Track track;
  for (double at = 0; at <= length; at += 500) {
    track.keyframes.push_back({.travelled = at});
    track.poses.push_back({.x = at});
  }
  return track;
}

TEST(Uncertainty, GrowsWithTheWay) {
  const Track track = straight(300000);
  Uncertainty uncertainty(track, {});
  const std::size_t last = track.poses.size() - 1;
  uncertainty.look_from(last);
  EXPECT_LT(uncertainty.window(last).distance, 500);
  double before = 0;
  for (const double way : {10000.0, 30000.0, 100000.0, 250000.0}) {
    const std::size_t place = last - static_cast<std::size_t>(way / 500);
    EXPECT_NEAR(uncertainty.way(place), way, 1500);
    EXPECT_GT(uncertainty.window(place).distance, before);
    before = uncertainty.window(place).distance;
  }
  EXPECT_GT(before, 20000) << "a drift of a degree in 20 m after 250 m";
  EXPECT_LE(uncertainty.window(0).distance, 40000);
  EXPECT_LE(uncertainty.window(0).turn, radians(40));
}

TEST(Uncertainty, IsSmallWhereLoopsAreClosed) {
  const Track track = straight(300000);
  const std::size_t last = track.poses.size() - 1;
  const Edge loop{.from = 20, .to = last - 20, .step = {}, .information = Information::Identity()};
  Uncertainty uncertainty(track, std::span(&loop, 1));
  uncertainty.look_from(last);
  EXPECT_LT(uncertainty.way(20), 15000) << "over the loop";
  EXPECT_LT(uncertainty.window(20).distance, 2000);
  EXPECT_GT(uncertainty.way(last / 2), 100000) << "the middle is far from both";
}

TEST(Uncertainty, OfKeyframesByOdometryAloneIsLarge) {
  Track track = straight(20000);
  Uncertainty sure(track, {});
  sure.look_from(40);
  track.keyframes[20].placed = Placed::kByOdometry;
  Uncertainty unsure(track, {});
  unsure.look_from(40);
  EXPECT_GT(unsure.window(0).distance, 1.3 * sure.window(0).distance);
  EXPECT_DOUBLE_EQ(unsure.window(30).distance, sure.window(30).distance);
}

}  // namespace uncertainty_test

}  // namespace rack::mapping
