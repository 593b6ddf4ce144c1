// Points on two bare walls, laid on these.
#include "components/localisation/line_match.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::localisation {

namespace line_match_test {

// At y = -1000 and 1000; with an end, also at x = 3000.
class Corridor final : public Lines {
 public:
  explicit Corridor(bool has_end) : has_end_(has_end) {}
  [[nodiscard]] bool empty() const override { return false; }
  [[nodiscard]] const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const override {
    const bool is_end = std::abs(point.nx) > 0.7F;
    if (is_end && !has_end_) return nullptr;
    const ScanPoint2d& line = is_end ? end_ : point.y < 0 ? left_ : right_;
    const float off = line.nx * (point.x - line.x) + line.ny * (point.y - line.y);
    return std::abs(off) <= reach ? &line : nullptr;
  }

 private:
  bool has_end_;
  ScanPoint2d left_{0, -1000, 0, 1};
  ScanPoint2d right_{0, 1000, 0, -1};
  ScanPoint2d end_{3000, 0, -1, 0};
};

std::vector<ScanPoint2d> scan(float noise, float end_length) {
  Random random(1);
  std::vector<BeamEnd> ends;
  for (float x = -3000; x < 3000; x += 50) ends.push_back({x, -1000 + noise * random.normal()});
  for (float y = -end_length; y < end_length; y += 50) ends.push_back({3000, y});
  for (float x = 3000; x > -3000; x -= 50) ends.push_back({x, 1000 + noise * random.normal()});
  std::vector<ScanPoint2d> points;
  points_of(ends, {}, 1, points);
  return points;
}

TEST(LineMatch, DoesNotDetermineThePositionAlongACorridor) {
  const auto found = match(Corridor(false), scan(0, 0), {.x = 30, .y = 50, .rho = 0.02});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pose.y, 0, 0.5);
  EXPECT_NEAR(signed_angle(found->pose.rho), 0, 0.0005);
  EXPECT_LT(found->information(0, 0), 1e-4 * found->information(1, 1));
}

TEST(LineMatch, AFewPointsDoNotDetermineTheDistance) {
  const Pose start{.x = 30, .y = 50};
  const Prior prior{.pose = start, .information = Information::Identity() * 1e-6};
  const MatchSettings sceptical{.least_information = 8};
  for (const float end_length : {120.0F, 800.0F}) {
    const auto believes = match(Corridor(true), scan(0, end_length), start, prior);
    const auto doubts = match(Corridor(true), scan(0, end_length), start, prior, sceptical);
    ASSERT_TRUE(believes && doubts);
    EXPECT_NEAR(believes->pose.x, 0, 3) << end_length;
    EXPECT_NEAR(doubts->pose.x, end_length > 500 ? 0 : 30, 3) << end_length;
    EXPECT_NEAR(doubts->pose.y, 0, 1) << end_length;
  }
}

TEST(LineMatch, MeasuresWhatPointsErr) {
  double last = 1e9;
  for (const float noise : {5.0F, 15.0F, 30.0F}) {
    const MatchSettings settings{.measures_noise = true, .least_distance = 0, .least_turn = 0};
    const auto found = match(Corridor(false), scan(noise, 0), {}, {}, settings);
    ASSERT_TRUE(found);
    const double deviation = 1 / std::sqrt(found->information(1, 1));
    const double expected = static_cast<double>(noise) / std::sqrt(found->points);
    EXPECT_GT(deviation, 0.8 * expected) << noise;
    EXPECT_LT(deviation, 1.8 * expected) << noise;
    EXPECT_LT(found->information(1, 1), last);
    last = found->information(1, 1);
  }
}

TEST(LineMatch, DenseScansHaveWallsToo) {
  std::vector<BeamEnd> ends;
  for (float x = -1000; x < 1000; x += 4) ends.push_back({x, 900});
  std::vector<ScanPoint2d> points;
  points_of(ends, {}, 1, points);
  EXPECT_FALSE(points.at(20).on_wall()) << "16 mm are no wall";
  points_of(ends, {}, 6, points);
  ASSERT_GT(points.size(), 30U);
  for (std::size_t i = 3; i + 3 < points.size(); ++i) EXPECT_NEAR(points[i].ny, -1, 0.01) << i;
}

}  // namespace line_match_test

}  // namespace rack::localisation
