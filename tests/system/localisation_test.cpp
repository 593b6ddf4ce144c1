// A robot with a floor plan localises itself by its scanner and publishes its position; maps are
// shown and edited.
#include <cmath>

#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/odometry.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace localisation_test {

// The simulated scanner is at the odometry's position, so the odometry is the ground truth here.
class LocalisationTest : public RobotTest {
 protected:
  // Starts in the room in the middle, because the corridor looks the same from both of its ends.
  void start_robot(std::vector<std::string> localisation) {
    start("ChassisSim");
    start("OdometryChassis", {"--initPosX", "3000", "--initPosY", "2500", "--initPosRho", "80"});
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
  // The distance of the estimate from the truth at the same time, in mm; or the reason of a
  // failure.
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

TEST_F(LocalisationTest, LocalisesItselfAndPublishesItsPosition) {
  start_robot({"--mapFile", FLOOR_PLAN, "--startMode", "1", "--positionInst", "0", "--period",
               "200", "--maxRange", "10000"});
  ASSERT_TRUE(turned_on("Position(0/0)"));
  auto position = proxy<rack::PositionProxy>("Position(0/0)");
  EXPECT_EQ(position.get_data()->pos.x, 0) << "it does not know the map";
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
  start_robot({"--startX", "2900", "--startY", "2400", "--startRho", "75", "--period", "200"});
  auto mcl = proxy<rack::MclProxy>("Mcl(0/0)");
  EXPECT_FALSE(mcl.on().ok()) << "without a map";
  EXPECT_FALSE(mcl.load_map("/nowhere/floor.dxf").ok());
  EXPECT_FALSE(mcl.load_map("/proc/self/status").ok()) << "not a map";
  ASSERT_TRUE(mcl.load_map(FLOOR_PLAN).ok());
  ASSERT_TRUE(turned_on("Mcl(0/0)"));
  let_drive();
  ASSERT_TRUE(found());
  EXPECT_FALSE(mcl.load_map("/nowhere/floor.dxf").ok());
  ASSERT_TRUE(mcl.load_map(FLOOR_PLAN).ok()) << "also while it is on";
  ASSERT_TRUE(found());
}

class PositionTest : public RobotTest {};

// The odometry interpolates between its data sets; its frame is that of the world here.
TEST_F(PositionTest, IsKnownBetweenDataSets) {
  start("ChassisSim", {"--vxMax=2000", "--omegaMax=90"});
  start("OdometryChassis");
  start("Position");
  ASSERT_TRUE(turned_on("Position(0/0)"));
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  ASSERT_TRUE(chassis.set_active_pilot(Address(kWork)));
  auto position = proxy<rack::PositionProxy>("Position(0/0)");
  auto odometry = proxy<rack::OdometryProxy>("Odometry(0/0)");
  rack::TimeStamp looked = 0;
  double y = 0;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(chassis.move(2000, 0, 0.5F));
    ASSERT_TRUE(eventually(
        [&] {
          const auto now = position.get_data();
          const bool is_new = now && now->recordingTime != looked;
          if (is_new) looked = now->recordingTime;
          return is_new;
        },
        "the next data set"));
    if (i < 3) continue;  // there is no data set so old
    const rack::TimeStamp then = looked - std::chrono::milliseconds(7 + 13 * i);
    const auto at = position.get_data(then);
    ASSERT_TRUE(at) << at.error().message();
    const auto truth = odometry.get_data(then);
    ASSERT_TRUE(truth) << truth.error().message();
    EXPECT_EQ(at->recordingTime, then);
    EXPECT_NEAR(at->pos.x.raw(), truth->pos.x.raw(), 2);
    EXPECT_NEAR(at->pos.y.raw(), truth->pos.y.raw(), 2);
    y = std::abs(truth->pos.y.raw());
  }
  EXPECT_GT(y, 10) << "it has driven";
  const auto ahead = position.get_data(looked + std::chrono::milliseconds(50));
  ASSERT_TRUE(ahead) << ahead.error().message();
  EXPECT_LE(ahead->recordingTime - looked, std::chrono::milliseconds(200))
      << "it does not extrapolate";
}

class MapsTest : public RobotTest {};

TEST_F(MapsTest, LinesAreEditedAndSaved) {
  const TemporaryFolder folder;
  ::setenv("RACK_FILES", folder.path().c_str(), 1);
  const std::string saved = "saved.dxf";
  start("FeatureMap", {"--mapFile", FLOOR_PLAN, "--period", "50"});
  auto map = proxy<rack::FeatureMapProxy>("FeatureMap(0/0)");
  ASSERT_TRUE(turned_on("FeatureMap(0/0)"));
  const auto whole = map.get_data();
  ASSERT_TRUE(whole.ok()) << whole.error().message();
  const std::size_t count = whole->features.size();
  ASSERT_GT(count, 10U);
  ASSERT_TRUE(map.add_line({.feature = {.x = 1, .y = 2, .x2 = 3, .y2 = 4, .layer = 7}}).ok());
  EXPECT_FALSE(map.add_line({.feature = {.x = 1, .y = 2, .x2 = 3, .y2 = 4, .layer = 70}}).ok());
  const auto has = [&](std::size_t wanted) {
    return eventually([&] { return map.get_data()->features.size() == wanted; }, "the edited map");
  };
  ASSERT_TRUE(has(count + 1));
  ASSERT_TRUE(map.displace_line({.feature = {.x = 5, .y = 2, .x2 = 5, .y2 = 4},
                                 .featureNumTemp = static_cast<rack::i32>(count)})
                  .ok());
  ASSERT_TRUE(map.delete_line({.featureNumTemp = 0}).ok());
  EXPECT_FALSE(map.delete_line({.featureNumTemp = 1000}).ok()) << "nothing was marked";
  ASSERT_TRUE(has(count));
  EXPECT_EQ(map.get_data()->features.back().x, 5);
  ASSERT_TRUE(map.save_map(saved).ok());
  EXPECT_FALSE(map.save_map("/tmp/map.dxf").ok());

  rack::FeatureMapLayerData layers;
  layers.layers = {7};
  ASSERT_TRUE(map.set_layer(layers).ok());
  EXPECT_EQ(map.get_layer()->layers.size(), 1U);
  ASSERT_TRUE(has(1));
  ASSERT_TRUE(map.load_map(saved).ok());
  ASSERT_TRUE(has(count)) << "a loaded map shows all layers";
  EXPECT_FALSE(map.load_map("/nowhere/map.dxf").ok());
  ASSERT_TRUE(has(count)) << "the old map is kept";
}

TEST_F(MapsTest, CellsOfTheWholeMapAndOfAPart) {
  start("GridMap", {"--mapFile", FLOOR_PLAN, "--mapResolution", "10", "--period", "50"});
  auto map = proxy<rack::GridMapProxy>("GridMap(0/0)");
  ASSERT_TRUE(turned_on("GridMap(0/0)"));
  const auto whole = map.get_data();
  ASSERT_TRUE(whole.ok()) << whole.error().message();
  EXPECT_GT(whole->scale, 10) << "1300 x 1100 cells are too many";
  EXPECT_GE(whole->gridNumX * whole->scale.raw(), 10000);

  start("ChassisSim");
  start("OdometryChassis");
  start("Position");
  start("GridMap", {"--instance", "1", "--mapFile", FLOOR_PLAN, "--mapResolution", "10", "--period",
                    "50", "--positionInst", "0"});
  ASSERT_TRUE(turned_on("Position(0/0)"));
  auto near = proxy<rack::GridMapProxy>("GridMap(0/1)");
  ASSERT_TRUE(turned_on("GridMap(0/1)"));
  const auto contains = [&](rack::i32 x, rack::i32 y) {
    const auto part = near.get_data();
    if (!part) return false;
    const auto inside = [](rack::i32 at, rack::i32 first, rack::i32 count) {
      return at >= first && at < first + 10 * count;
    };
    return part->scale == 10 && inside(x, part->offsetX, part->gridNumX) &&
           inside(y, part->offsetY, part->gridNumY);
  };
  EXPECT_TRUE(contains(0, 0));
  EXPECT_FALSE(contains(7000, 9000));
  ASSERT_TRUE(
      proxy<rack::PositionProxy>("Position(0/0)").update({.pos = {.x = 7000, .y = 9000}}).ok());
  EXPECT_TRUE(eventually([&] { return contains(7000, 9000); }, "the part around the robot"));
}

}  // namespace localisation_test
}  // namespace tims::test
