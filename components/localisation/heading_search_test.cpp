#include "components/localisation/heading_search.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "components/geometry/floor_map.h"

namespace rack::localisation {
namespace heading_search_test {

// A yard of 16 m x 12 m that looks the same after half a turn, unless there is a shed in it.
DxfDrawing yard(bool has_shed) {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
  };
  wall(-6, -8, 6, -8);
  wall(-6, 8, 6, 8);
  wall(-6, -8, -6, 8);
  wall(6, -8, 6, 8);
  if (has_shed) {
    wall(2, 2, 4, 2);
    wall(2, 2, 2, 5);
    wall(2, 5, 4, 5);
    wall(4, 2, 4, 5);
  }
  return drawing;
}

std::optional<HeadingSearch> search(bool has_shed, const Pose& truth, const Pose& place,
                                    double deviation) {
  FloorMap rays(yard(has_shed), 1000, 0, 0);
  const auto field = LikelihoodField::of(*read_map(yard(has_shed), 1000, 0, 0, 50), {});
  std::array<double, 181> ranges{};
  rays.cast({{truth.x, truth.y}, truth.rho - kPi / 2, kPi / 180}, 20000, ranges);
  std::vector<BeamEnd> scan;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double angle = radians(static_cast<double>(i) - 90);
    scan.push_back({static_cast<float>(ranges[i] * std::cos(angle)),
                    static_cast<float>(ranges[i] * std::sin(angle))});
  }
  return find_heading(*field, scan, place, deviation);
}

TEST(HeadingSearch, FindsTheHeadingAndThePlace) {
  for (const double degrees : {0, 37, 84, 170, 181, 270, 355}) {
    const Pose truth{.x = -900, .y = -1100, .rho = radians(degrees)};
    const auto found = search(true, truth, {.x = 300, .y = -2000}, 1500);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->pose.x, truth.x, 150) << degrees;
    EXPECT_NEAR(found->pose.y, truth.y, 150) << degrees;
    EXPECT_NEAR(signed_angle(found->pose.rho - truth.rho), 0, radians(2)) << degrees;
  }
}

TEST(HeadingSearch, IsClearOnlyWhenNoOtherHeadingFits) {
  // In the middle a half turn looks the same; 2.5 m beside it does not, if the place is known.
  EXPECT_FALSE(search(false, {.rho = 1}, {}, 500)->is_clear());
  EXPECT_TRUE(
      search(false, {.x = 2500, .y = 4000, .rho = 1}, {.x = 2500, .y = 4000}, 500)->is_clear());
}

TEST(HeadingSearch, WhatFitsNowhereIsNotClear) {
  const auto elsewhere = search(true, {.rho = 1}, {.x = 100'000, .y = 0}, 500);
  ASSERT_TRUE(elsewhere);
  EXPECT_FALSE(elsewhere->is_clear());
  const auto field = LikelihoodField::of(*read_map(yard(true), 1000, 0, 0, 50), {});
  EXPECT_FALSE(find_heading(*field, {}, {}, 1000)) << "no points";
  const std::array odd = {BeamEnd{NAN, 1}, BeamEnd{1, INFINITY}};
  EXPECT_FALSE(find_heading(*field, odd, {}, 1000));
  const std::array one = {BeamEnd{1000, 0}};
  EXPECT_TRUE(find_heading(*field, one, {}, NAN)) << "a place is enough";
  EXPECT_TRUE(find_heading(*field, one, {}, 1e9));
}

}  // namespace heading_search_test
}  // namespace rack::localisation
