#include "components/perception/clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace rack::perception {
namespace clusters_test {

// Circles and a box around a scanner at the origin, half a degree between beams.
class Scene {
 public:
  Scene& leg(double x, double y) {
    legs_.push_back({x, y});
    return *this;
  }
  Scene& wall(MapPoint from, MapPoint to) {
    drawing_.lines.push_back({{from.y / 1000, from.x / 1000}, {to.y / 1000, to.x / 1000}});
    return *this;
  }
  ScanView view(double first = -90, double last = 90) {
    Scan2dData scan{.maxRange = 20000};
    const FloorMap walls(drawing_, 1000, 0, 0);
    for (double degree = first; degree <= last; degree += 0.5) {
      std::array<double, 1> range{};
      const double angle = radians(degree);
      walls.cast({.from = {}, .first = angle, .step = 0.1}, 20000, range);
      for (const MapPoint& at : legs_) {
        const double along = at.x * std::cos(angle) + at.y * std::sin(angle);
        const double beside = at.x * at.x + at.y * at.y - along * along;
        if (along > 0 && beside < 3600)
          range[0] = std::min(range[0], along - std::sqrt(3600 - beside));
      }
      const bool nothing = range[0] >= 20000;
      scan.points.push_back({.x = whole_millimetres(range[0] * std::cos(angle)),
                             .y = whole_millimetres(range[0] * std::sin(angle)),
                             .z = whole_millimetres(range[0]),
                             .type = nothing ? 0x30 : 0});
    }
    ScanView made;
    made.take(scan, {}, 20000);
    return made;
  }

 private:
  DxfDrawing drawing_;
  std::vector<MapPoint> legs_;
};

TEST(Clusters, LegsAreDistinguishedAndStandWhereTheyAre) {
  ClusterFinder finder;
  const ScanView view = Scene().leg(3000, -150).leg(3100, 150).view();
  const auto found = finder.find(view, 12000);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].leg);
  EXPECT_NEAR(found[0].box.centre.x, 3000, 20);
  EXPECT_NEAR(found[0].box.centre.y, -150, 20);
  EXPECT_NEAR(found[1].box.centre.x, 3100, 20);
}

TEST(Clusters, ALegBeforeAWallIsNoPartOfIt) {
  ClusterFinder finder;
  const ScanView view = Scene().leg(2000, 0).wall({4000, -3000}, {4000, 3000}).view();
  const auto found = finder.find(view, 12000);
  EXPECT_EQ(std::ranges::count_if(found, &Cluster::leg), 1);
  const ScanView without = Scene().wall({4000, -3000}, {4000, 3000}).view();
  ASSERT_EQ(finder.find(without, 12000).size(), 1U) << "a wall is one";
  EXPECT_TRUE(finder.find(without, 3000).empty()) << "and larger than wanted";
}

TEST(Clusters, FindsThePersonMovingBeforeAWall) {
  ClusterFinder finder;
  ScanView view = Scene().leg(3800, 0).wall({4000, -3000}, {4000, 3000}).view();
  for (Sight& sight : view.sights()) sight.moved = sight.away < 3850 && std::abs(sight.y) < 80;
  const auto found = finder.find(view, 12000);
  const auto moved = std::ranges::find_if(found, [](const Cluster& c) { return c.moved == 1; });
  ASSERT_NE(moved, found.end());
  EXPECT_TRUE(moved->leg);
  EXPECT_NEAR(moved->box.centre.x, 3800, 30);
}

TEST(Clusters, AroundTheBackOfTheScan) {
  ClusterFinder finder;
  const ScanView view = Scene().leg(-3000, 0).view(-180, 179.5);
  ASSERT_TRUE(view.full_turn());
  EXPECT_EQ(finder.find(view, 12000).size(), 1U);
}

TEST(Clusters, NearAndFarInTurnsAsInMergedScans) {
  Scan2dData scan;
  for (int i = 0; i < 40; ++i)
    scan.points.push_back({.x = i % 2 == 0 ? 2000 : 6000, .y = (i - 20) * (i % 2 == 0 ? 20 : 60)});
  ScanView view;
  view.take(scan, {}, 20000);
  ClusterFinder finder;
  EXPECT_EQ(finder.find(view, 12000).size(), 2U);
}

TEST(Clusters, ExplainedPointsAreNone) {
  ClusterFinder finder;
  ScanView view = Scene().leg(3000, 0).view();
  for (Sight& sight : view.sights()) sight.explained = true;
  EXPECT_TRUE(finder.find(view, 12000).empty());
}

}  // namespace clusters_test
}  // namespace rack::perception
