// Several scanners merged into one, objects that are not on the map, and scans that mark them: the
// real programs with a simulated robot at rest in the middle room of the floor plan.
#include <cmath>

#include <gmock/gmock.h>

#include "rack/proxies/feature_map.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace perception_test {

class PerceptionTest : public RobotTest {
 protected:
  void start_robot() {
    start("ChassisSim");
    start("OdometryChassis", {"--initPosX", "3000", "--initPosY", "2500"});
    start_scanner(0);
  }
  void start_scanner(int instance) {
    start("Scan2dSim", {"--instance", std::to_string(instance), "--mapFile", FLOOR_PLAN});
  }
  // Waits until the scan has so many points.
  testing::AssertionResult has_points(const std::string& address, std::size_t count) {
    return eventually([&]() -> std::string {
      const auto scan = proxy<rack::Scan2dProxy>(address).get_data();
      if (!scan) return scan.error().message();
      return scan->points.size() == count ? "" : std::to_string(scan->points.size()) + " points";
    });
  }
};

TEST_F(PerceptionTest, ScansAreMergedAndAMissingOneIsOmitted) {
  start_robot();
  start_scanner(1);
  start("Scan2dMerge", {"--instance", "5", "--scan2dInstA", "1", "--scan2dInstB", "0"});
  ASSERT_TRUE(turned_on("Scan2d(0/5)"));
  ASSERT_TRUE(has_points("Scan2d(0/5)", 722));
  const auto merged = proxy<rack::Scan2dProxy>("Scan2d(0/5)").get_data();
  ASSERT_TRUE(merged.ok()) << merged.error().message();
  const auto angle = [](const rack::ScanPoint& p) { return std::atan2(p.y.raw(), p.x.raw()); };
  EXPECT_TRUE(std::ranges::is_sorted(merged->points, {}, angle));
  EXPECT_EQ(std::ranges::count(merged->points, 1, &rack::ScanPoint::segment), 361);
  kill("Scan2dSim");  // the first one started
  ASSERT_TRUE(has_points("Scan2d(0/5)", 361));
  start_scanner(0);
  EXPECT_TRUE(has_points("Scan2d(0/5)", 722)) << "the scanner is used again";
}

TEST_F(PerceptionTest, OneScannerOfTwoIsEnough) {
  start_robot();
  start("Scan2dMerge", {"--instance", "5", "--scan2dInstA", "0", "--scan2dInstB", "7"});
  ASSERT_TRUE(turned_on("Scan2d(0/5)"));
  EXPECT_TRUE(has_points("Scan2d(0/5)", 361));
}

// A wall is deleted from the map, so it becomes an object.
TEST_F(PerceptionTest, AWallMissingOnTheMapIsAnObjectAndItsPointsAreMarked) {
  start_robot();
  start("Position");
  start("FeatureMap", {"--mapFile", FLOOR_PLAN, "--period", "50"});
  ASSERT_TRUE(turned_on("FeatureMap(0/0)"));
  auto map = proxy<rack::FeatureMapProxy>("FeatureMap(0/0)");
  const auto whole = map.get_data();
  ASSERT_TRUE(whole.ok()) << whole.error().message();
  const auto nearest = std::ranges::min_element(whole->features, {}, [](const auto& line) {
    const double x = (line.x.raw() + line.x2.raw()) / 2.0 - 3000;
    const double y = (line.y.raw() + line.y2.raw()) / 2.0 - 2500;
    return std::hypot(x, y);
  });
  const auto place = static_cast<rack::i32>(nearest - whole->features.begin());
  ASSERT_TRUE(map.delete_line({.featureNumTemp = place}).ok());
  ASSERT_TRUE(
      eventually([&] { return map.get_data()->features.size() + 1 == whole->features.size(); },
                 "the edited map"));

  // Position starts at the origin, so it is set to the robot's position.
  ASSERT_TRUE(turned_on("Position(0/0)"));
  rack::PositionData here;
  const auto odometry = proxy<rack::OdometryProxy>("Odometry(0/0)").get_data();
  ASSERT_TRUE(odometry.ok());
  here.recordingTime = odometry->recordingTime;
  here.pos = odometry->pos;
  ASSERT_TRUE(proxy<rack::PositionProxy>("Position(0/0)").update(here).ok());
  start("ObjRecogScan2d", {"--scan2dInst", "0", "--positionInst", "0", "--featureMapInst", "0",
                           "--maxRange", "9999"});
  start("Scan2dDynObjRecog",
        {"--instance", "3", "--scan2dInst", "0", "--objRecogInst", "0", "--vMin", "0"});
  ASSERT_TRUE(turned_on("ObjRecog(0/0)"));
  ASSERT_TRUE(turned_on("Scan2d(0/3)"));
  auto recogniser = proxy<rack::ObjRecogProxy>("ObjRecog(0/0)");
  ASSERT_TRUE(eventually([&]() -> std::string {
    const auto objects = recogniser.get_data();
    if (!objects) return objects.error().message();
    return objects->objects.empty() ? "no object" : "";
  }));
  const auto objects = recogniser.get_data();
  EXPECT_EQ(objects->refPos.x, 3000);
  EXPECT_EQ(objects->objects[0].vel.x, 0) << "it does not move";
  const auto marked = [&]() -> std::string {
    const auto scan = proxy<rack::Scan2dProxy>("Scan2d(0/3)").get_data();
    if (!scan) return scan.error().message();
    const auto count = std::ranges::count_if(
        scan->points, [](const auto& p) { return (p.type & rack::scan_point::kClassMask) == 3; });
    return count > 5 ? "" : std::to_string(count) + " dynamic points";
  };
  EXPECT_TRUE(eventually(marked));

  EXPECT_FALSE(recogniser.set_estimate({}).ok());
  rack::ObjRecogData wrong;
  wrong.objects.push_back({.objectId = -5});
  EXPECT_FALSE(recogniser.stop_recog(wrong).ok());
  EXPECT_TRUE(recogniser.stop_recog({}).ok());
  ASSERT_TRUE(eventually(marked)) << "it is found again";

  // Scans continue without object recognition.
  kill("ObjRecogScan2d");
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto scan = proxy<rack::Scan2dProxy>("Scan2d(0/3)").get_next_data(kPatience);
    if (!scan) return scan.error().message();
    return std::ranges::any_of(scan->points, [](const auto& p) { return (p.type & 3) == 3; })
               ? "still dynamic points"
               : "";
  }));
}

}  // namespace perception_test
}  // namespace tims::test
