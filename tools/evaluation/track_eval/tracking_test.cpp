#include "tools/evaluation/track_eval/tracking.h"

#include <cmath>

#include <gtest/gtest.h>

#include "base/statistics.h"

namespace rack::track_eval {
namespace tracking_test {

double no_clock() { return 0; }

class PeopleTest : public testing::TestWithParam<bool> {};

// The results of the README, with a shorter time.
TEST_P(PeopleTest, AreFollowed) {
  const bool localised = GetParam();
  const auto map = localisation::read_map(Hall::plan(), 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  const auto field = localisation::LikelihoodField::of(*map, {});
  ASSERT_TRUE(field.ok());
  for (const std::uint64_t seed : {11U, 12U}) {
    const Score score = follow_people({.seed = seed, .localised = localised}, 60,
                                      localised ? &*field : nullptr, no_clock);
    EXPECT_GT(score.people, 2000U);
    EXPECT_GE(score.mota(), localised ? 0.98 : 0.93) << seed;
    EXPECT_LT(tims::base::mean(score.speed), 200) << seed;
    EXPECT_LT(tims::base::mean(score.off), 60) << seed;
  }
}
INSTANTIATE_TEST_SUITE_P(WithAndWithoutAMap, PeopleTest, testing::Bool());

// A scanner with a field of view of 180 degrees; from 7 m a leg is hit by a single beam.
TEST(People, AreFollowedByHalfATurnWithoutAMap) {
  for (const std::uint64_t seed : {11U, 12U}) {
    const Score score =
        follow_people({.seed = seed, .beams = 181, .opening = 180}, 300, nullptr, no_clock);
    EXPECT_GT(score.people, 2000U);
    EXPECT_GE(score.mota(), 0.9) << seed;
  }
}

TEST(People, NobodyIsThereAndNobodyIsReported) {
  const Score score = follow_people({.people = 0}, 60, nullptr, no_clock);
  EXPECT_EQ(score.people, 0U);
  EXPECT_EQ(score.wrong, 0U);
  EXPECT_EQ(score.ghosts, 0U);
}

TEST(People, TheScoreCountsWhatIsWrong) {
  Score score;
  EXPECT_EQ(score.mota(), 0);
  score.people = 100;
  score.missed = 5;
  score.wrong = 4;
  score.switches = 1;
  EXPECT_DOUBLE_EQ(score.mota(), 0.9);
}

TEST(Hall, IsTheSameFromTheSameSeed) {
  Hall one({.seed = 4});
  Hall other({.seed = 4});
  Scan2dData a;
  Scan2dData b;
  for (int i = 0; i < 50; ++i) {
    one.step();
    other.step();
    one.scan(a);
    other.scan(b);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) EXPECT_EQ(a.points[i].z, b.points[i].z);
  EXPECT_EQ(one.people()[0].at.x, other.people()[0].at.x);
}

TEST(EvenTimes, BunchesAreSpread) {
  std::vector<localisation::LogScan> scans(400);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::size_t bunch = i / 4;
    scans[i].time = 0.8 * static_cast<double>(bunch) + 0.001 * static_cast<double>(i % 4);
  }
  const std::vector<double> times = even_times(scans);
  for (std::size_t i = 30; i + 30 < scans.size(); ++i)
    EXPECT_NEAR(times[i + 1] - times[i], 0.2, 0.05) << i;
}

TEST(EvenTimes, OthersStayAsTheyAre) {
  std::vector<localisation::LogScan> scans(100);
  for (std::size_t i = 0; i < scans.size(); ++i)
    scans[i].time = 0.2 * static_cast<double>(i) + (i > 50 ? 0.4 : 0) + (i > 70 ? 100 : 0);
  const std::vector<double> times = even_times(scans);
  for (std::size_t i = 0; i < scans.size(); ++i) EXPECT_EQ(times[i], scans[i].time);
  EXPECT_TRUE(even_times({}).empty());
}

// A synthetic log of a room of 8 m x 8 m with a walking person.
TEST(Drive, SomebodyWalks) {
  localisation::CarmenLog log;
  log.range_max = 50;
  for (int n = 0; n < 60; ++n) {
    localisation::LogScan scan{.time = n * 0.1,
                               .logger_time = n * 0.1,
                               .first = radians(-90),
                               .step = radians(1),
                               .begin = log.ranges.size(),
                               .count = 181};
    const MapPoint leg{2500, -2500 + n * 100.0};
    for (int i = 0; i <= 180; ++i) {
      const double angle = radians(i - 90);
      double range = std::min(4000 / std::max(std::cos(angle), 1e-9),
                              4000 / std::max(std::abs(std::sin(angle)), 1e-9));
      const double along = leg.x * std::cos(angle) + leg.y * std::sin(angle);
      if (std::abs(leg.x * std::sin(angle) - leg.y * std::cos(angle)) < 100)
        range = std::min(range, along);
      log.ranges.push_back(static_cast<float>(range / 1000));
    }
    log.scans.push_back(scan);
  }
  const DriveScore score = follow_drive(log, {}, no_clock);
  EXPECT_EQ(score.scans, 60U);
  ASSERT_EQ(score.movers.size(), 1U);
  EXPECT_NEAR(score.movers[0].speed, 1000, 200);
  EXPECT_GT(score.movers[0].distance, 2000);
  EXPECT_EQ(score.movers[0].kind, perception::ObjectKind::kPedestrian);
}

}  // namespace tracking_test
}  // namespace rack::track_eval
