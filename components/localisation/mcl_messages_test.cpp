#include "components/localisation/mcl_messages.h"

#include <gtest/gtest.h>

namespace rack::localisation {

namespace mcl_messages_test {

TEST(MclMessages, PointsThatAMapCannotExplainAreLeftOut) {
  Scan2dData scan;
  scan.points.push_back({.x = 1000, .y = 100, .z = 1005});
  scan.points.push_back({.x = 1, .z = 1000, .type = scan_point::kInvalid});
  scan.points.push_back({.x = 2, .z = 1000, .type = scan_point::kMaxRange});
  scan.points.push_back({.x = 3, .z = 1000, .type = 3});
  scan.points.push_back({.x = 4, .z = 1000, .type = scan_point::kReflector | 2});
  scan.points.push_back({.x = 5, .z = 0});
  scan.points.push_back({.x = 6, .z = 5000});
  std::vector<BeamEnd> ends;
  beams_of(scan, 5000, ends);
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_EQ(ends[0].x, 1000);
  EXPECT_EQ(ends[0].y, 100);
  EXPECT_EQ(ends[1].x, 4);
}

LikelihoodField field() {
  const std::vector<MapLine> walls{{{0, 0}, {4000, 0}},
                                   {{4000, 0}, {4000, 3000}},
                                   {{4000, 3000}, {0, 3000}},
                                   {{0, 3000}, {0, 0}}};
  auto made = LikelihoodField::of(*draw_walls(walls, 50), {});
  EXPECT_TRUE(made.ok());
  return std::move(made).value();
}

TEST(MclMessages, SamplesAndMeasurementsFitIntoAMessage) {
  const LikelihoodField map = field();
  for (const std::uint32_t count : {10U, 700U, 5000U}) {
    LocaliserSettings settings{.beams = 800};
    settings.filter.particles = count;
    Localiser localiser(settings, 1);
    localiser.start_at({.x = 1000, .y = 2000}, 10, 0.001);
    const std::vector<BeamEnd> ends(800, BeamEnd{500, 1000});
    localiser.take(map, {}, ends);
    MclData data;
    to_message(localiser, 42, data);
    EXPECT_EQ(data.recordingTime, TimeStamp(42));
    EXPECT_NEAR(data.pos.x, 1000, 30);
    std::size_t samples = 0;
    for (const MclDataPoint& point : data.points) {
      if (point.type == mcl_point::kSample) {
        ++samples;
        EXPECT_NEAR(point.x, 1000, 100);
      } else {
        EXPECT_EQ(point.type, mcl_point::kMeasurement);
        EXPECT_EQ(point.z, 1118);
        EXPECT_NEAR(point.x, data.pos.x + 500, 30);
      }
    }
    EXPECT_EQ(samples, std::min<std::size_t>(localiser.filter().size(), 500));
    EXPECT_EQ(data.points.size(), std::min<std::size_t>(1000, samples + 800));
  }
}

TEST(MclMessages, UpdatesSayHowSureTheyAre) {
  Localiser localiser({}, 1);
  localiser.start_at({.x = 1000, .y = 2000, .rho = 1}, 250, 0.1);
  const PositionData update = to_update(localiser, 7);
  EXPECT_EQ(update.recordingTime, TimeStamp(7));
  EXPECT_EQ(update.pos.x, 1000);
  EXPECT_EQ(update.var.x, 250);
  EXPECT_NEAR(update.var.rho, 0.1, 1e-6);
}

TEST(MclMessages, SureIsOnePlaceThatIsSmall) {
  Estimate estimate{.covariance = {.xx = 100, .yy = 100}, .share = 1};
  EXPECT_TRUE(is_sure(estimate, 10));
  EXPECT_FALSE(is_sure(estimate, 9));
  estimate.share = 0.5;
  EXPECT_FALSE(is_sure(estimate, 10));
}

}  // namespace mcl_messages_test

}  // namespace rack::localisation
