// The simulated robot drives along walls, autonomously and by joystick, and recovers from a crash
// of its odometry.
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>

#include "components/geometry/floor_map.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/scan2d.h"
#include "tests/system/robot_fixture.h"
#include "tests/system/stick_pipe.h"

namespace tims::test {
namespace robot_test {

constexpr double kHull = 354;  // distance of ChassisSim's corners from its centre, mm

rack::FloorMap floor() {
  std::ifstream file(FLOOR_PLAN);
  const auto drawing = rack::read_dxf(std::string(std::istreambuf_iterator<char>(file), {}));
  EXPECT_TRUE(drawing.ok());
  return {*drawing, 1000, 0, 0};
}

class DrivingTest : public RobotTest {
 protected:
  void start_robot() {
    start("ChassisSim");
    start("OdometryChassis");
    start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
    start("Position");
  }
  void start_wall_following(const std::string& mode) {
    start("PilotWallFollowing",
          {"--instance", "1", "--scan2dInst", "0", "--maxSpeed", "700", "--mode", mode});
  }

  // Turns the components on in the order of the graphical interface.
  void let_drive(const std::string& pilot) {
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
    const auto active = chassis.set_active_pilot(*Address::parse(pilot));
    ASSERT_TRUE(active.ok()) << active.error().message();
    ASSERT_TRUE(turned_on(pilot));
  }

  // Waits until the robot has moved by more than `distance` mm, and checks the distance of the
  // walls all the time.
  testing::AssertionResult moves(
      double distance, const std::function<void()>& drive = [] {}) {
    auto position = proxy<rack::PositionProxy>("Position(0/0)");
    std::optional<rack::Position3d> from;
    return eventually([&]() -> std::string {
      drive();
      const auto now = position.get_data();
      if (!now) return now.error().message();
      if (!from) from = now->pos;
      const double x = now->pos.x;
      const double y = now->pos.y;
      clearance_ = std::min(clearance_, map_.clearance({x, y}));
      const double gone = std::hypot(x - from->x, y - from->y);
      return gone > distance ? "" : "it has moved by " + std::to_string(gone) + " mm";
    });
  }

  rack::FloorMap map_ = floor();
  double clearance_ = 1e9;
};

TEST_F(DrivingTest, AlongWalls) {
  start_robot();
  start_wall_following("0");
  let_drive("Pilot(0/1)");
  EXPECT_TRUE(moves(2000));
  EXPECT_GT(clearance_, kHull);
  const auto pilot = proxy<rack::PilotProxy>("Pilot(0/1)").get_data();
  ASSERT_TRUE(pilot.ok()) << pilot.error().message();
  EXPECT_NE(pilot->recordingTime, rack::TimeStamp(0));
}

TEST_F(DrivingTest, ContinuesWhenItsOdometryHasRestarted) {
  start_robot();
  start_wall_following("1");
  let_drive("Pilot(0/1)");
  EXPECT_TRUE(moves(200));
  kill("OdometryChassis");
  auto pilot = proxy<rack::PilotProxy>("Pilot(0/1)");
  EXPECT_TRUE(eventually(
      [&] {
        const auto status = pilot.status();
        return status && *status == rack::Status::kError;
      },
      "the pilot in error"));
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  EXPECT_TRUE(eventually(
      [&] {
        const auto data = chassis.get_data();
        return data && data->vx == 0.0F;
      },
      "it has stopped: no pilot drives without data"));
  start("OdometryChassis");
  EXPECT_TRUE(eventually(
      [&] {
        const auto status = pilot.status();
        return status && *status == rack::Status::kEnabled;
      },
      "the pilot on again"));
  EXPECT_TRUE(moves(200));
  EXPECT_GT(clearance_, kHull);
}

TEST_F(DrivingTest, ScansOfALadarAreConvertedToPoints) {
  start_robot();
  start("LadarSim", {"--mapFile", FLOOR_PLAN, "--angleMin", "-90", "--angleMax", "90"});
  start("Scan2d", {"--instance", "1", "--ladarInst", "0", "--positionInst", "0"});
  ASSERT_TRUE(turned_on("Scan2d(0/1)"));
  ASSERT_TRUE(turned_on("Scan2d(0/0)"));
  const auto scan = proxy<rack::Scan2dProxy>("Scan2d(0/1)").get_data();
  const auto simulated = proxy<rack::Scan2dProxy>("Scan2d(0/0)").get_data();
  ASSERT_TRUE(scan.ok() && simulated.ok());
  ASSERT_EQ(scan->points.size(), 181U);
  ASSERT_EQ(simulated->points.size(), 361U);
  EXPECT_NE(scan->recordingTime, rack::TimeStamp(0));
  for (std::size_t i = 0; i < scan->points.size(); ++i) {
    EXPECT_NEAR(scan->points[i].x, simulated->points[i + 90].x, 2);
    EXPECT_NEAR(scan->points[i].y, simulated->points[i + 90].y, 2);
  }
}

TEST_F(DrivingTest, SendsTheTime) {
  start("ClockSystem");
  ASSERT_TRUE(turned_on("Clock(0/0)"));
  const auto clock = proxy<rack::ClockProxy>("Clock(0/0)").get_data();
  ASSERT_TRUE(clock.ok()) << clock.error().message();
  EXPECT_NEAR(static_cast<double>(clock->utcTime), static_cast<double>(::time(nullptr)), 60);
  EXPECT_GT(clock->year, 2000) << "like the original program";
}

// The clock of the test must not be synchronised: the component would set the clock of this host.
TEST_F(DrivingTest, RequestsTheTimeOfAnotherClock) {
  start("ClockSystem", {"--instance", "1"});
  start("ClockSystem",
        {"--clockInst", "1", "--systemClockUpdate", "1", "--systemClockUpdateTime", "1000"});
  ASSERT_TRUE(turned_on("Clock(0/0)"));
  EXPECT_EQ(*proxy<rack::ClockProxy>("Clock(0/1)").status(), rack::Status::kEnabled);
  const auto clock = proxy<rack::ClockProxy>("Clock(0/0)").get_data();
  ASSERT_TRUE(clock.ok()) << clock.error().message();
  EXPECT_EQ(clock->syncMode, 0) << "the other one is not synchronised";
}

TEST_F(DrivingTest, APositionIsKept) {
  start("ChassisSim");
  start("OdometryChassis", {"--initPosX", "700"});
  start("Position", {"--positionReference", "2", "--autoOffset", "1"});
  auto position = proxy<rack::PositionProxy>("Position(0/0)");
  const auto at = [&] {
    const auto data = position.get_data();
    return data ? data->pos.x.raw() : -1;
  };
  ASSERT_TRUE(turned_on("Position(0/0)"));
  EXPECT_EQ(at(), 0) << "the origin, independent of the odometry's start";
  ASSERT_TRUE(position.update({.pos = {.x = 5000}}).ok());
  EXPECT_TRUE(eventually([&] { return at() == 5000; }, "the update"));
  ASSERT_TRUE(position.off().ok());
  ASSERT_TRUE(turned_on("Position(0/0)"));
  EXPECT_EQ(at(), 5000);
  kill("OdometryChassis");
  EXPECT_TRUE(eventually([&] { return !position.get_data().ok(); }, "in error"));
  start("OdometryChassis");
  EXPECT_TRUE(eventually([&] { return at() == 5000; }, "on again, where it was"));

  ASSERT_TRUE(position.wgs84_to_pos({.latitude = -0.5, .longitude = 2.6}).ok());
  const auto parameters = position.get_param();
  ASSERT_TRUE(parameters.ok()) << parameters.error().message();
  const auto zone = std::ranges::find_if(
      parameters->parameters, [](const rack::Parameter& p) { return p.name == "utmZone"; });
  ASSERT_NE(zone, parameters->parameters.end());
  EXPECT_EQ(zone->valueInt, 55) << "of the first place that was converted";
}

TEST_F(DrivingTest, ByJoystick) {
  const std::string device = router_.folder() + "/js0";
  StickPipe stick(device);
  start_robot();
  start("Joystick", {"--device", device, "--periodTime", "20"});
  start("PilotJoystick", {"--scan2dInst", "0", "--mode", "1", "--maxSpeed", "700"});
  let_drive("Pilot(0/0)");
  ASSERT_TRUE(turned_on("Position(0/0)"));
  auto pilot = proxy<rack::PilotProxy>("Pilot(0/0)");
  // As users do: after an error due to lack of CPU time, the stick must be released first.
  const auto drive = [&] {
    const auto status = pilot.status();
    stick.push(status && *status == rack::Status::kEnabled ? 32767 : 0);
  };
  EXPECT_TRUE(moves(1000, drive));
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  const auto speed = [&] {
    const auto data = chassis.get_data();
    return data ? data->vx.raw() : -1.0F;
  };
  stick.push(0);
  EXPECT_TRUE(eventually([&] { return speed() == 0.0F; }, "standing"));
  // Without a joystick the pilot stops.
  EXPECT_TRUE(eventually(
      [&] {
        drive();
        return speed() > 100.0F;
      },
      "driving"));
  kill("Joystick");
  EXPECT_TRUE(eventually([&] { return speed() == 0.0F; }, "standing without joystick"));
  EXPECT_GT(clearance_, kHull);
}

}  // namespace robot_test
}  // namespace tims::test
