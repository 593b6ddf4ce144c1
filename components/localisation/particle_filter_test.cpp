#include "components/localisation/particle_filter.h"

#include <cmath>

#include <gtest/gtest.h>

namespace rack::localisation {

namespace particle_filter_test {

// An L of 8 m x 6 m: no two places look alike.
LikelihoodField field() {
  const std::vector<MapLine> walls{{{0, 0}, {8000, 0}},          {{8000, 0}, {8000, 3000}},
                                   {{8000, 3000}, {3000, 3000}}, {{3000, 3000}, {3000, 6000}},
                                   {{3000, 6000}, {0, 6000}},    {{0, 6000}, {0, 0}}};
  const auto map = draw_walls(walls, 50);
  EXPECT_TRUE(map.ok());
  auto made = LikelihoodField::of(*map, {});
  EXPECT_TRUE(made.ok());
  return std::move(made).value();
}

TEST(PoseBins, TheHeaviestIsFound) {
  PoseBins bins(1000);
  for (int i = 0; i < 100; ++i) bins.add(static_cast<float>(600 * i), 100, 1, 0.001F);
  bins.add(-700, -700, 6.28F, 0.3F);
  bins.add(-300, -700, 0.01F, 0.3F);  // its neighbour, across 0
  const auto heaviest = bins.heaviest();
  EXPECT_NEAR(heaviest.middle.x, -500, 300);
  EXPECT_NEAR(heaviest.middle.y, -750, 1);
  EXPECT_EQ(bins.count(), 102U);
  bins.clear();
  EXPECT_EQ(bins.count(), 0U);
  EXPECT_EQ(bins.heaviest().weight, 0);
}

TEST(ParticleFilter, StartsAtTheGivenPose) {
  ParticleFilter filter({.particles = 20000}, 1);
  filter.start_at({.x = 1000, .y = -2000, .rho = 6.2}, 200, 0.1);
  const Estimate estimate = filter.estimate();
  EXPECT_NEAR(estimate.pose.x, 1000, 10);
  EXPECT_NEAR(estimate.pose.y, -2000, 10);
  EXPECT_NEAR(signed_angle(estimate.pose.rho - 6.2), 0, 0.01);
  EXPECT_NEAR(std::sqrt(estimate.covariance.xx), 200, 10);
  EXPECT_NEAR(std::sqrt(estimate.covariance.yy), 200, 10);
  EXPECT_NEAR(std::sqrt(estimate.covariance.rho_rho), 0.1, 0.01);
  EXPECT_GT(estimate.share, 0.99);
}

TEST(ParticleFilter, MovesAheadAndGrows) {
  const FilterSettings settings{.particles = 20000, .slip_share = 0};
  ParticleFilter filter(settings, 1);
  filter.start_at({.rho = kPi / 2}, 0, 0);
  for (int i = 0; i < 10; ++i) filter.move({.x = 100});
  const Estimate estimate = filter.estimate();
  EXPECT_NEAR(estimate.pose.x, 0, 5);
  EXPECT_NEAR(estimate.pose.y, 1000, 5);
  const double step = settings.distance_least + settings.along_by_distance * 100;
  EXPECT_NEAR(std::sqrt(estimate.covariance.yy), step * std::sqrt(10), 1) << "along";
  const double turn = settings.turn_least + settings.turn_by_distance * 0.1;
  EXPECT_NEAR(std::sqrt(estimate.covariance.rho_rho), turn * std::sqrt(10), 0.001);
}

TEST(ParticleFilter, TheSameSeedIsTheSameCloud) {
  const LikelihoodField map = field();
  Beams beams;
  for (int i = 0; i < 20; ++i) beams.add({100.0F * static_cast<float>(i), 700});
  const auto cloud = [&](std::uint64_t seed) {
    ParticleFilter filter({}, seed);
    filter.start_anywhere(map, beams);
    filter.move({.x = 50, .rho = 0.1});
    filter.weigh(map, beams);
    (void)filter.estimate();
    filter.resample(map, beams, {});
    std::vector<double> values;
    for (std::size_t i = 0; i < filter.size(); ++i) values.push_back(filter.particle(i).x);
    return values;
  };
  EXPECT_EQ(cloud(7), cloud(7));
  EXPECT_NE(cloud(7), cloud(8));
}

TEST(ParticleFilter, ManyWhereItIsSpreadAndFewWhereNot) {
  const LikelihoodField map = field();
  Beams beams;
  beams.add({1000, 0});
  const FilterSettings settings{.particles = 100, .particles_max = 5000};
  ParticleFilter filter(settings, 3);
  filter.start_anywhere(map, beams);
  EXPECT_EQ(filter.size(), settings.particles_max);
  (void)filter.estimate();
  filter.resample(map, beams, {});
  EXPECT_GT(filter.size(), 2000U);
  filter.start_at({.x = 1000, .y = 1000}, 50, 0.02);
  (void)filter.estimate();
  filter.resample(map, beams, {});
  EXPECT_LT(filter.size(), 300U);
}

TEST(ParticleFilter, WithoutBeamsNothingIsLearnt) {
  const LikelihoodField map = field();
  ParticleFilter filter({}, 3);
  filter.start_at({.x = 1000, .y = 1000}, 100, 0.1);
  filter.weigh(map, {});
  (void)filter.estimate();
  filter.resample(map, {}, {});
  EXPECT_EQ(filter.injected(), 0U);
  EXPECT_NEAR(filter.estimate().pose.x, 1000, 30);
}

TEST(ParticleFilter, WhatIsFavouredHasSoMuchOfTheWeight) {
  ParticleFilter filter({}, 1);
  filter.start_at({}, 3000, 0.1);
  const double share = filter.estimate_near({}).share;
  EXPECT_LT(share, 0.2);
  filter.favour({.x = 1e6}, 0.5);
  EXPECT_DOUBLE_EQ(filter.estimate_near({}).share, share) << "nothing is there";
  filter.favour({}, 0.5);
  EXPECT_NEAR(filter.estimate_near({}).share, 0.5, 0.05);
  const double favoured = filter.estimate_near({}).share;
  filter.favour({}, 0.3);
  EXPECT_DOUBLE_EQ(filter.estimate_near({}).share, favoured) << "it has more";
}

}  // namespace particle_filter_test

}  // namespace rack::localisation
