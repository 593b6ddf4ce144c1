// A robot in a mapped floor plan finds out where it is, by its scanner, and tells its position.
#include <cmath>

#include "rack/proxies/mcl.h"
#include "rack/proxies/odometry.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace {

// The simulated scanner is where the odometry says: that is the truth here.
class LocalisationTest : public RobotTest {
 protected:
  void start_robot(std::vector<std::string> localisation) {
    start("ChassisSim");
    start("OdometryChassis", {"--initPosX", "500", "--initPosY", "3000", "--initPosRho", "80"});
    start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
    start("Position");
    start("PilotWallFollowing",
          {"--instance", "1", "--scan2dInst", "0", "--maxSpeed", "700", "--mode", "0"});
    start("MonteCarloLocalisation", std::move(localisation));
  }
  void let_drive() {
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
    ASSERT_TRUE(chassis.set_active_pilot(*Address::parse("Pilot(0/1)")).ok());
    ASSERT_TRUE(turned_on("Pilot(0/1)"));
  }
  // How far the estimate is from the truth of its time, mm; or why this is not known.
  Result<double> off() {
    const auto mcl = proxy<rack::MclProxy>("Mcl(0/0)").get_data();
    if (!mcl) return mcl.error();
    const auto truth = proxy<rack::OdometryProxy>("Odometry(0/0)").get_data(mcl->recordingTime);
    if (!truth) return truth.error();
    return std::hypot(mcl->pos.x.raw() - truth->pos.x.raw(), mcl->pos.y.raw() - truth->pos.y.raw());
  }
  testing::AssertionResult found() {
    return eventually([&]() -> std::string {
      const auto now = off();
      if (!now) return now.error().message();
      return *now < 150 ? "" : std::to_string(*now) + " mm off";
    });
  }
};

TEST_F(LocalisationTest, FindsItselfAndTellsItsPosition) {
  start_robot({"--mapFile", FLOOR_PLAN, "--startMode", "1", "--positionInst", "0", "--period",
               "200", "--maxRange", "10000"});
  ASSERT_TRUE(turned_on("Position(0/0)"));
  auto position = proxy<rack::PositionProxy>("Position(0/0)");
  EXPECT_EQ(position.get_data()->pos.x, 0) << "it knows nothing of the map";
  ASSERT_TRUE(turned_on("Mcl(0/0)"));
  let_drive();
  ASSERT_TRUE(found());
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto now = position.get_data();
    if (!now) return now.error().message();
    const auto truth = proxy<rack::OdometryProxy>("Odometry(0/0)").get_data(now->recordingTime);
    if (!truth) return truth.error().message();
    const double off =
        std::hypot(now->pos.x.raw() - truth->pos.x.raw(), now->pos.y.raw() - truth->pos.y.raw());
    return off < 200 ? "" : std::to_string(off) + " mm off";
  }));
  const auto data = proxy<rack::MclProxy>("Mcl(0/0)").get_data();
  ASSERT_TRUE(data.ok());
  const auto count = [&](int type) {
    return std::ranges::count_if(data->points, [&](const auto& p) { return p.type == type; });
  };
  EXPECT_GE(count(rack::mcl_point::kSample), 500);
  EXPECT_GT(count(rack::mcl_point::kMeasurement), 30);
}

TEST_F(LocalisationTest, AMapIsLoadedWhileItIsOff) {
  start_robot({"--startX", "400", "--startY", "2900", "--startRho", "75", "--period", "200"});
  auto mcl = proxy<rack::MclProxy>("Mcl(0/0)");
  EXPECT_FALSE(mcl.on().ok()) << "without a map";
  EXPECT_FALSE(mcl.load_map("/nowhere/floor.dxf").ok());
  EXPECT_FALSE(mcl.load_map("/proc/self/status").ok()) << "no map";
  ASSERT_TRUE(mcl.load_map(FLOOR_PLAN).ok());
  ASSERT_TRUE(turned_on("Mcl(0/0)"));
  let_drive();
  ASSERT_TRUE(found());
  EXPECT_FALSE(mcl.load_map("/nowhere/floor.dxf").ok());
  ASSERT_TRUE(mcl.load_map(FLOOR_PLAN).ok()) << "also while it is on";
  ASSERT_TRUE(found());
}

}  // namespace
}  // namespace tims::test
