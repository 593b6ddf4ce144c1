#include "components/vision/person_tracks.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::vision {
namespace person_tracks_test {

constexpr double kPeriod = 0.2;  // s

PersonSighting at(double x, double y, double deviation = 100) {
  return {.at = {x, y},
          .covariance = Eigen::Matrix2d::Identity() * deviation * deviation,
          .probability = 0.9};
}

void take(PersonTracks& tracks, std::vector<PersonSighting> sightings, double time) {
  tracks.take(sightings, time);
}

std::size_t confirmed(const PersonTracks& tracks) {
  return static_cast<std::size_t>(
      std::ranges::count_if(tracks.tracks(), &PersonTrack::is_confirmed));
}

TEST(PersonTracks, BeginWithTheSecondPicture) {
  PersonTracks tracks;
  take(tracks, {at(4000, 0)}, 1);
  EXPECT_EQ(confirmed(tracks), 0U);
  take(tracks, {at(4010, 0)}, 1 + kPeriod);
  ASSERT_EQ(confirmed(tracks), 1U);
  EXPECT_EQ(tracks.tracks()[0].id(), 1);
  EXPECT_EQ(tracks.tracks()[0].sighting(), 0U);
  EXPECT_NEAR(tracks.tracks()[0].probability(1 + kPeriod), 0.9, 1e-9);
}

TEST(PersonTracks, EndAfterASecond) {
  PersonTracks tracks;
  take(tracks, {at(4000, 0)}, 1);
  take(tracks, {at(4000, 0)}, 1.25);
  take(tracks, {}, 2.25);
  ASSERT_EQ(confirmed(tracks), 1U);
  EXPECT_FALSE(tracks.tracks()[0].sighting());
  EXPECT_NEAR(tracks.tracks()[0].probability(2.25), 0, 1e-9);
  EXPECT_NEAR(tracks.tracks()[0].probability(1.75), 0.45, 1e-9);
  take(tracks, {}, 2.2501);
  EXPECT_TRUE(tracks.tracks().empty());
}

TEST(PersonTracks, GoOnAfterAGap) {
  PersonTracks tracks;
  double time = 0;
  for (int i = 0; i < 20; ++i, time += kPeriod)
    if (i % 4 != 3)
      take(tracks, {at(4000, 1000 * time)}, time);
    else
      take(tracks, {}, time);
  ASSERT_EQ(tracks.tracks().size(), 1U);
  EXPECT_EQ(tracks.tracks()[0].id(), 1);
}

TEST(PersonTracks, EstimateTheVelocity) {
  PersonTracks tracks;
  Random random(3);
  constexpr double kNoise = 150;
  double time = 100;
  double squares = 0;
  int pictures = 0;
  for (; time < 120; time += kPeriod) {
    const double walked = 1200 * (time - 100);
    take(tracks,
         {at(2000 + 0.6 * walked + kNoise * random.normal(),
             -5000 + 0.8 * walked + kNoise * random.normal(), kNoise)},
         time);
    if (time < 103) continue;
    ASSERT_EQ(tracks.tracks().size(), 1U);
    const PersonTrack& track = tracks.tracks()[0];
    squares += (track.velocity() - Eigen::Vector2d(720, 960)).squaredNorm() / 2;
    EXPECT_NEAR(track.at().x(), 2000 + 0.6 * walked, 3.5 * kNoise);
    ++pictures;
  }
  const double deviation = std::sqrt(squares / pictures);
  const double stated = std::sqrt(tracks.tracks()[0].velocity_covariance()(0, 0));
  EXPECT_LT(deviation, 400);
  EXPECT_LT(deviation, 1.5 * stated);
  EXPECT_GT(deviation, 0.3 * stated);
}

TEST(PersonTracks, WhoStandsHasNoVelocity) {
  PersonTracks tracks;
  for (int i = 0; i < 30; ++i) take(tracks, {at(4000, 500)}, i * kPeriod);
  EXPECT_LT(tracks.tracks()[0].velocity().norm(), 1);
}

TEST(PersonTracks, KeepTwoWhoPassEachOther) {
  PersonTracks tracks;
  for (int i = 0; i <= 30; ++i) {
    const double walked = 1000 * i * kPeriod;
    std::vector<PersonSighting> both = {at(4000, -3000 + walked), at(4600, 3000 - walked)};
    if (i % 2 == 1) std::swap(both[0], both[1]);
    take(tracks, both, i * kPeriod);
  }
  ASSERT_EQ(tracks.tracks().size(), 2U);
  EXPECT_EQ(tracks.tracks()[0].id(), 1);
  EXPECT_NEAR(tracks.tracks()[0].at().y(), 3000, 200);
  EXPECT_NEAR(tracks.tracks()[1].at().y(), -3000, 200);
}

TEST(PersonTracks, AnotherPersonIsOutsideTheGate) {
  PersonTracks tracks;
  for (int i = 0; i < 20; ++i) take(tracks, {at(4000, 0)}, i * kPeriod);
  const double gate = 3.03 * std::sqrt(tracks.tracks()[0].covariance()(0, 0) + 100 * 100);
  PersonTracks others = tracks;
  take(tracks, {at(4000 + 0.9 * gate, 0)}, 20 * kPeriod);
  EXPECT_EQ(tracks.tracks().size(), 1U);
  take(others, {at(4000 + 1.3 * gate, 0)}, 20 * kPeriod);
  EXPECT_EQ(others.tracks().size(), 2U);
}

TEST(PersonTracks, ForgetWhenTheTimeGoesBack) {
  PersonTracks tracks;
  take(tracks, {at(4000, 0)}, 50);
  take(tracks, {at(4000, 0)}, 50.2);
  take(tracks, {at(4000, 0), at(9000, 0)}, 50.2);
  EXPECT_EQ(tracks.tracks().size(), 1U) << "the same picture again";
  take(tracks, {at(4000, 0)}, 49);
  ASSERT_EQ(tracks.tracks().size(), 1U);
  EXPECT_EQ(confirmed(tracks), 0U);
  EXPECT_EQ(tracks.tracks()[0].id(), 2);
}

TEST(PersonTracks, AreBounded) {
  PersonTracks tracks;
  std::vector<PersonSighting> crowd;
  for (std::size_t i = 0; i <= PersonTracks::kTracksMax; ++i)
    crowd.push_back(at(static_cast<double>(i) * 5000, 0));
  take(tracks, crowd, 1);
  EXPECT_EQ(tracks.tracks().size(), PersonTracks::kTracksMax);
}

TEST(PersonTracks, IgnoreWhatIsNotANumber) {
  PersonTracks tracks;
  const double nan = std::nan("");
  PersonSighting singular = at(1000, 0);
  singular.covariance.setZero();
  take(tracks, {at(nan, 0), at(0, nan), at(0, 0, nan), singular}, 1);
  EXPECT_TRUE(tracks.tracks().empty());
}

}  // namespace person_tracks_test
}  // namespace rack::vision
