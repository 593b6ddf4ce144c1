#include "tools/map_maker/track_error.h"

#include <gtest/gtest.h>

namespace rack::map_maker {

namespace {

std::vector<Pose> track() {
  return {
      {.x = 0, .y = 0, .rho = 0}, {.x = 1000, .y = 0, .rho = 1}, {.x = 1000, .y = 2000, .rho = 2}};
}

TEST(TrackError, LaysTheTrackOnTheTruthFirst) {
  const Pose elsewhere{.x = -5000, .y = 300, .rho = 2.5};
  mcl_eval::Truth truth;
  for (std::size_t i = 0; i < track().size(); ++i)
    truth.poses.push_back({i, elsewhere + track()[i]});
  for (const double metres : track_error(track(), truth).metres) EXPECT_NEAR(metres, 0, 1e-9);
  for (const double degrees : track_error(track(), truth).degrees) EXPECT_NEAR(degrees, 0, 1e-9);
  truth.poses[1].laser.rho += radians(3);
  EXPECT_NEAR(track_error(track(), truth).degrees[1], 3, 1e-9);
}

TEST(TrackError, SaysHowAStepDiffersFromARelation) {
  mcl_eval::Truth truth;
  truth.relations.push_back({0, 1, {.x = 900, .y = 0, .rho = 1}});
  truth.relations.push_back({1, 2, (track()[2] - track()[1])});
  const TrackError error = track_error(track(), truth);
  ASSERT_EQ(error.metres.size(), 2U);
  EXPECT_NEAR(error.metres[0], 0.1, 1e-9);
  EXPECT_NEAR(error.metres[1], 0, 1e-9);
}

}  // namespace

}  // namespace rack::map_maker
