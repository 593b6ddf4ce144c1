#include "components/vision/robot_fix.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"
#include "components/vision/fix_gate.h"
#include "components/vision/rendered_markers.h"

namespace rack::vision {
namespace robot_fix_test {

// A corridor to the north with markers on both of its walls and at its end.
std::vector<Marker> corridor() {
  return {{.id = 1, .at = {2000, 1000}, .rho = heading(radians(-90)), .height = 600, .size = 200},
          {.id = 2, .at = {3000, -1000}, .rho = heading(radians(90)), .height = 600, .size = 200},
          {.id = 3, .at = {5000, 200}, .rho = kPi, .height = 600, .size = 200}};
}

std::vector<Landmark> landmarks_of(const Rendered& picture, std::span<const Marker> map,
                                   const CameraGeometry& camera) {
  std::vector<Landmark> landmarks;
  const auto found = MarkerFinder({Family::kTag36h11}).find(picture.view());
  for (const Sighting& seen : *found)
    for (const Marker& marker : map)
      if (seen.shows(marker))
        if (const auto poses = poses_of(seen, marker.size, camera))
          landmarks.push_back({marker, seen.corners, *poses});
  return landmarks;
}

double distance(const Pose& a, const Pose& b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST(RobotFix, IsWhereTheMarkersAreSeenFrom) {
  const auto map = corridor();
  const CameraGeometry camera = test_camera({.x = 150, .y = -20, .z = -500, .psi = 0.05});
  int fixed = 0;
  for (const Pose& pose :
       {Pose{}, Pose{.x = 500, .y = 200, .rho = 0.1},
        Pose{.x = 2500, .y = -300, .rho = heading(-0.2)}, Pose{.x = 1000, .y = -500, .rho = 0.5},
        Pose{.x = 1000, .y = 500, .rho = heading(-0.6)}, Pose{.x = 3500, .y = 0, .rho = 0.2}}) {
    const auto landmarks = landmarks_of(rendered(map, pose, camera, 4, 0.5), map, camera);
    ASSERT_FALSE(landmarks.empty());
    const auto fixes = fixes_of(landmarks, camera);
    ASSERT_FALSE(fixes.empty());
    const RobotFix& fix = fixes.front();
    EXPECT_LT(fix.error, 1.5);
    EXPECT_LT(distance(fix.pose, pose), 4 * fix.deviation + 5) << fix.deviation;
    EXPECT_LT(std::abs(signed_angle(fix.pose.rho - pose.rho)), 4 * fix.deviation_rho);
    EXPECT_LT(distance(fix.pose, pose), 100);
    fixed += fix.markers == landmarks.size() ? 1 : 0;
  }
  EXPECT_EQ(fixed, 6) << "all markers agree";
}

TEST(RobotFix, AMarkerThatWasMovedIsLeftOut) {
  auto map = corridor();
  const CameraGeometry camera = test_camera();
  const Pose pose{.x = -500, .y = 100};
  const Rendered picture = rendered(map, pose, camera, 2, 0);
  map[1].at.y += 700;  // the map is wrong
  const auto fixes = fixes_of(landmarks_of(picture, map, camera), camera);
  ASSERT_FALSE(fixes.empty());
  EXPECT_EQ(fixes.front().markers, 2U);
  EXPECT_LT(distance(fixes.front().pose, pose), 100);
}

TEST(RobotFix, NoMarkersNoFix) { EXPECT_TRUE(fixes_of({}, test_camera()).empty()); }

TEST(RobotFix, CornersOfAnythingNeverBreakIt) {
  const CameraGeometry camera = test_camera();
  const auto map = corridor();
  Random random(11);
  for (int i = 0; i < 2000; ++i) {
    Sighting seen{.id = 1};
    for (ImagePoint& corner : seen.corners)
      corner = {random.uniform() * 2000 - 700, random.uniform() * 2000 - 700};
    const auto poses = poses_of(seen, 200, camera);
    if (!poses) continue;
    const Landmark landmark{map[0], seen.corners, *poses};
    for (const RobotFix& fix : fixes_of(std::span(&landmark, 1), camera)) {
      EXPECT_TRUE(std::isfinite(fix.pose.x + fix.pose.y + fix.pose.rho + fix.deviation));
      EXPECT_GT(fix.deviation, 0);
    }
  }
}

// --- the gate

RobotFix fix_at(double x, double y, double rho = 0) {
  return {.pose = {.x = x, .y = y, .rho = rho},
          .deviation = 30,
          .deviation_rho = 0.01,
          .error = 0.3,
          .markers = 1};
}

TEST(FixGate, SendsWhatIsNearAtOnce) {
  FixGate gate;
  const RobotFix near = fix_at(100, 50);
  EXPECT_TRUE(gate.take(std::span(&near, 1), {}, 50));
  const RobotFix turned = fix_at(0, 0, radians(16));
  EXPECT_FALSE(gate.take(std::span(&turned, 1), {}, 50));
  const RobotFix far = fix_at(2000, 0);
  EXPECT_FALSE(gate.take(std::span(&far, 1), {}, 50));
  EXPECT_TRUE(gate.take(std::span(&far, 1), {}, 1000)) << "Position is uncertain";
}

TEST(FixGate, OfTwoTheOneThatIsBelieved) {
  FixGate gate;
  const std::array<RobotFix, 2> both = {fix_at(3000, 0), fix_at(20, 0)};
  const auto sent = gate.take(both, {}, 50);
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->pose.x, 20);
}

TEST(FixGate, ARobotThatWasCarriedAwayIsFoundAfterSeveralPictures) {
  FixGate gate;
  Pose believed;
  Pose truth{.x = 5000, .y = 3000, .rho = 2};
  for (int picture = 1; picture <= FixGate::kAgreeing; ++picture) {
    const RobotFix fix = fix_at(truth.x, truth.y, truth.rho);
    EXPECT_EQ(gate.take(std::span(&fix, 1), believed, 50).has_value(),
              picture == FixGate::kAgreeing);
    const Pose step{.x = 70, .y = 5, .rho = 0.05};
    truth = truth + step;
    believed = believed + step;
  }
}

TEST(FixGate, PicturesThatContradictEachOtherSendNothing) {
  FixGate gate;
  for (int picture = 0; picture < 30; ++picture) {
    const RobotFix fix = fix_at(picture % 2 == 0 ? 5000 : -5000, 0);
    EXPECT_FALSE(gate.take(std::span(&fix, 1), {}, 50));
  }
  const std::array<RobotFix, 2> both = {fix_at(5000, 0), fix_at(6000, 0)};
  for (int picture = 0; picture < 30; ++picture) EXPECT_FALSE(gate.take(both, {}, 50));
}

}  // namespace robot_fix_test
}  // namespace rack::vision
