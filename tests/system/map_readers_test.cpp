// All components with a map read floor plans and maps of ROS alike.
#include <cmath>

#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/path.h"
#include "rack/proxies/scan2d.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace map_readers_test {

const std::string kMaps = std::string(TIMS_SOURCES) + "/tests/data/maps/";

// The room has walls around 4 m x 3 m, its south west corner at x = -2 m, y = -1 m.
class MapReadersTest : public RobotTest {
 protected:
  void start_base() {
    start("ChassisSim");
    start("OdometryChassis", {"--initPosX=500", "--initPosY=0"});
    start("Position");
    ASSERT_TRUE(turned_on("Position(0/0)"));
  }
};

TEST_F(MapReadersTest, TheyTakeAMapOfRos) {
  if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "built without pictures";
  const std::string map = "--mapFile=" + kMaps + "m-plain.yaml";
  start_base();
  start("Scan2dSim", {map});
  start("LadarSim", {map});
  start("FeatureMap", {map});
  start("GridMap", {map});
  start("MonteCarloLocalisation", {map});
  start("ObjRecogScan2d", {map, "--scan2dInst=0", "--positionInst=0"});
  start("PathRDDF", {map, "--scan2dInst=-1"});
  for (const char* component : {"Scan2d(0/0)", "Ladar(0/0)", "FeatureMap(0/0)", "GridMap(0/0)",
                                "Mcl(0/0)", "ObjRecog(0/0)", "Path(0/0)"})
    EXPECT_TRUE(turned_on(component));
  const auto lines = proxy<rack::FeatureMapProxy>("FeatureMap(0/0)").get_data();
  ASSERT_TRUE(lines) << lines.error().message();
  EXPECT_GT(lines->features.size(), 3U);
  // In a straight line from wall to wall of the room.
  EXPECT_TRUE(eventually(
      [&] {
        const auto scan = proxy<rack::Scan2dProxy>("Scan2d(0/0)").get_data();
        if (!scan || scan->points.empty()) return false;
        for (const auto& point : scan->points)
          if (!(std::hypot(point.x.raw(), point.y.raw()) < 5000)) return false;
        return true;
      },
      "the scan sees the walls of the room"));
  auto path = proxy<rack::PathProxy>("Path(0/0)");
  rack::PathDestData goal;
  goal.pos.y = 1700;
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto sent = path.set_destination(goal);
    return sent ? "" : sent.error().message();
  }));
  goal.pos.y = 9000;
  EXPECT_TRUE(eventually([&] { return !path.set_destination(goal); }, "it is outside of the map"));
}

TEST_F(MapReadersTest, TheyTakeAChoiceOfLayers) {
  for (const char* program : {"FeatureMap", "Scan2dSim", "GridMap", "PathRDDF"})
    start(program, {"--mapFile=" + kMaps + "room-layers.dxf", "--mapLayers=walls"});
  start_base();
  for (const char* component : {"Scan2d(0/0)", "GridMap(0/0)", "Path(0/0)"})
    EXPECT_TRUE(turned_on(component));
  ASSERT_TRUE(turned_on("FeatureMap(0/0)"));
  const auto lines = proxy<rack::FeatureMapProxy>("FeatureMap(0/0)").get_data();
  ASSERT_TRUE(lines);
  EXPECT_EQ(lines->features.size(), 4U) << "without the exit";
}

}  // namespace map_readers_test
}  // namespace tims::test
