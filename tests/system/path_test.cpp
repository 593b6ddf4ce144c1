// A simulated robot is sent to destinations, along routes, and around obstacles.
#include "rack/proxies/path.h"

#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>

#include "components/geometry/floor_map.h"
#include "rack/proxies/planner.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace path_test {

constexpr const char* kChassis = "Chassis(0/0)";
constexpr const char* kPosition = "Position(0/0)";
constexpr const char* kPath = "Path(0/0)";
constexpr const char* kPilot = "Pilot(0/0)";

class PathTest : public RobotTest {
 protected:
  static constexpr auto kLong = 3 * kPatience;

  void start_robot(const std::vector<std::string>& of_position = {}) {
    start("ChassisSim", {"--omegaMax=90", "--periodTime=50", "--acceleration=1", "--vxMax=1000",
                         "--accMax=1000", "--decMax=1000"});
    start("OdometryChassis");
    start("Position", of_position);
  }
  void start_eyes() { start("Scan2dSim", {"--mapFile", FLOOR_PLAN}); }
  void let_drive(const std::string& pilot = kPilot) {
    ASSERT_TRUE(turned_on(kPosition));
    ASSERT_TRUE(turned_on(kChassis));
    ASSERT_TRUE(proxy<rack::ChassisProxy>(kChassis).set_active_pilot(*Address::parse(pilot)));
    ASSERT_TRUE(turned_on(pilot));
  }

  [[nodiscard]] testing::AssertionResult comes_to(double x, double y) {
    auto position = proxy<rack::PositionProxy>(kPosition);
    return eventually(
        [&]() -> std::string {
          const auto at = position.get_data();
          if (!at) return at.error().message();
          const double away = std::hypot(at->pos.x - x, at->pos.y - y);
          return away < 150 ? "" : "it is " + std::to_string(away) + " mm away";
        },
        kLong);
  }
  // A plan with a wall across the corridor that is not on the map.
  std::string plan_with_wall() {
    std::ifstream plan(FLOOR_PLAN);
    std::string text((std::istreambuf_iterator<char>(plan)), {});
    const std::string wall =
        "  0\nLINE\n  8\n1\n 10\n-1.5\n 20\n3.0\n 11\n0.1\n 21\n3.0\n  0\nENDSEC\n  0\nEOF\n";
    const auto end = text.rfind("ENDSEC");
    text = text.substr(0, text.rfind('0', end)) + wall.substr(wall.find('0'));
    std::string file = (folder_.path() / "obstacle.dxf").string();
    std::ofstream(file) << text;
    return file;
  }
  testing::AssertionResult drives(bool wanted) {
    return eventually(
        [&] {
          const auto status = proxy<rack::PilotProxy>(kPilot).get_status();
          return status && (status->speed != 0) == wanted;
        },
        wanted ? "it drives" : "it is commanded to stop");
  }
  rack::PathRddfData route(const std::vector<std::array<int, 3>>& points) {
    rack::PathRddfData data;
    for (const auto& [x, y, speed] : points) {
      rack::Waypoint2d waypoint;
      waypoint.x = x;
      waypoint.y = y;
      waypoint.speed = speed;
      data.waypoints.push_back(waypoint);
    }
    return data;
  }

  TemporaryFolder folder_;
};

TEST_F(PathTest, ThroughADoorToADestinationOnTheMap) {
  start_robot();
  start_eyes();
  start("PathRDDF", {"--mapFile", FLOOR_PLAN, "--scan2dInst=0", "--cellSize=50"});
  start("PilotPath", {"--scan2dInst=0", "--maxSpeed=700"});
  let_drive();
  auto pilot = proxy<rack::PilotProxy>(kPilot);
  rack::PilotDestData goal;
  goal.pos.x = 3500;
  goal.pos.y = 6000;
  goal.pos.rho = 3.0F;
  const auto sent = pilot.set_destination(goal);
  ASSERT_TRUE(sent.ok()) << sent.error().message();
  EXPECT_TRUE(comes_to(3500, 6000));
  EXPECT_TRUE(eventually(
      [&] {
        const auto status = pilot.get_status();
        return status && status->pilotState == rack::pilot_state::kIdle &&
               status->distanceToDest == 0;
      },
      "the pilot has reached its destination"));
  // Destinations in a wall, and outside of the map.
  goal.pos.x = 1500;
  const auto walled = pilot.set_destination(goal);
  ASSERT_FALSE(walled.ok());
  EXPECT_NE(walled.error().message().find("no room"), std::string::npos)
      << walled.error().message();
  goal.pos.x = 900000;
  EXPECT_FALSE(pilot.set_destination(goal).ok());
}

// The second destination is in a wall: the refusal is reported, the destination is kept, and a new
// one is accepted.
TEST_F(PathTest, ARefusedDestinationOfAListIsKept) {
  start_robot();
  start("PathRDDF", {"--mapFile", FLOOR_PLAN, "--cellSize=50"});
  start("PilotPath", {"--scan2dInst=-1", "--maxSpeed=700"});
  let_drive();
  auto pilot = proxy<rack::PilotProxy>(kPilot);
  rack::PilotMultiDestData list;
  list.points.push_back({.pos = {.x = 600}});
  list.points.push_back({.pos = {.x = 900000}});
  ASSERT_TRUE(pilot.set_multi_destination(list));
  EXPECT_TRUE(comes_to(600, 0));
  EXPECT_TRUE(eventually(
      [&] {
        const auto status = pilot.get_status();
        return status && status->pilotState == rack::pilot_state::kPathError;
      },
      "it reports that there is no path"));
  EXPECT_TRUE(drives(false));
  rack::PilotDestData goal;
  goal.pos.x = 1200;
  const auto sent = pilot.set_destination(goal);
  ASSERT_TRUE(sent.ok()) << sent.error().message();
  EXPECT_TRUE(comes_to(1200, 0));
}

// As the graphical interface sends them: the complete list at each click, speed 1 or -1, and MAKE
// with -1 for unknown fields.
TEST_F(PathTest, AlongClicksForwardAndBackward) {
  start_robot();
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1"});
  let_drive();
  auto path = proxy<rack::PathProxy>(kPath);
  const rack::PathMakeData as_it_is{-1, -1, -1, -1.0F};
  ASSERT_TRUE(path.set_rddf(route({{2000, 0, 1}})));
  ASSERT_TRUE(path.make(as_it_is));
  ASSERT_TRUE(path.set_rddf(route({{2000, 0, 1}, {3000, 1500, 1}})));
  ASSERT_TRUE(path.make(as_it_is));
  EXPECT_TRUE(comes_to(3000, 1500));
  ASSERT_TRUE(path.set_rddf(route({{2000, 0, -1}})));
  ASSERT_TRUE(path.make(as_it_is));
  EXPECT_TRUE(comes_to(2000, 0));
  const auto data = path.get_data();
  ASSERT_TRUE(data.ok());
  ASSERT_FALSE(data->splines.empty());
  EXPECT_LT(data->splines[0].length, 0);
  ASSERT_TRUE(path.set_rddf({}));
  ASSERT_TRUE(path.make(as_it_is));
  EXPECT_TRUE(eventually(
      [&] {
        const auto empty = path.get_data();
        return empty && empty->splines.empty();
      },
      "no path"));
}

TEST_F(PathTest, HoldsAndReturnsAlongItsPath) {
  start_robot();
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1"});
  let_drive();
  auto path = proxy<rack::PathProxy>(kPath);
  ASSERT_TRUE(path.set_rddf(route({{0, 0, 700}, {30000, 0, 700}})));
  ASSERT_TRUE(path.make({}));
  EXPECT_TRUE(comes_to(1000, 0));
  auto pilot = proxy<rack::PilotProxy>(kPilot);
  ASSERT_TRUE(pilot.hold_command({1, 0, {}}));
  auto chassis = proxy<rack::ChassisProxy>(kChassis);
  const auto speed = [&](auto holds) {
    return eventually(
        [&] {
          const auto data = chassis.get_data();
          return data && holds(data->vx.raw());
        },
        "the speed wanted");
  };
  EXPECT_TRUE(speed([](float vx) { return vx == 0; }));
  ASSERT_TRUE(pilot.hold_command({0, 0, {}}));
  EXPECT_TRUE(speed([](float vx) { return vx > 300; }));
  ASSERT_TRUE(pilot.revert_command(3000));
  EXPECT_TRUE(speed([](float vx) { return vx < -200; }));
  EXPECT_TRUE(speed([](float vx) { return vx > 300; }));
}

TEST_F(PathTest, ReadsARouteInGeographicCoordinates) {
  start_robot({"--positionReference=2", "--autoOffset=1"});
  start("PathRDDF", {"--rddfFile", std::string(ROUTES) + "/sunlot-rddf.txt", "--vMax=1000"});
  ASSERT_TRUE(turned_on(kPath));
  auto path = proxy<rack::PathProxy>(kPath);
  const auto data = path.get_data();
  ASSERT_TRUE(data.ok()) << data.error().message();
  EXPECT_GT(data->splines.size(), 20U);
  double length = 0;
  for (const auto& spline : data->splines) length += spline.length;
  EXPECT_NEAR(length, 400000, 60000);
  ASSERT_TRUE(path.set_layer(7));
  EXPECT_EQ(*path.get_layer(), 7);
  EXPECT_FALSE(path.get_dbg_gridmap().ok());  // it has no map
}

TEST_F(PathTest, FindsAPathAroundAnObstacle) {
  start_robot();
  start("Scan2dSim", {"--mapFile", plan_with_wall()});
  start("PathRDDF", {"--mapFile", FLOOR_PLAN, "--scan2dInst=0", "--cellSize=50", "--lbo=1300"});
  start("PilotPath", {"--scan2dInst=0", "--maxSpeed=700", "--replanTime=300"});
  let_drive();
  auto path = proxy<rack::PathProxy>(kPath);
  const auto map = path.get_dbg_gridmap();
  ASSERT_TRUE(map.ok()) << map.error().message();
  EXPECT_EQ(map->scale, 50);
  EXPECT_GT(std::ranges::count(map->occupancy, rack::u8{255}), 100);
  ASSERT_TRUE(path.set_rddf(route({{0, 0, 700}, {7000, 0, 700}})));
  ASSERT_TRUE(path.make({}));
  EXPECT_TRUE(comes_to(7000, 0));
}

// A path component in the test, which delays its answer whether there is a path around.
class PathOfTheTest {
 public:
  PathOfTheTest(Mailbox mailbox, rack::PathData data)
      : mailbox_(std::move(mailbox)), data_(std::move(data)), thread_([this] { serve(); }) {}
  ~PathOfTheTest() {
    ending_ = true;
    thread_.join();
  }
  [[nodiscard]] bool is_asked() const { return is_asked_; }
  // From now on it answers requests, with a refusal.
  void refuse() { refuses_ = true; }

 private:
  void serve() {
    std::optional<Address> listener;
    std::optional<Header> replan;
    while (!ending_) {
      if (const auto message = mailbox_.peek_for(20ms)) {
        const Header& header = message->header();
        if (header.type == rack::PathType::kReplan) {
          replan = header;
          is_asked_ = true;
        } else if (header.type == type::kGetContData) {
          listener = rack::decode<rack::GetContDataRequest>({header, message->body()})->dataMbxAdr;
          reply(header, type::kContData, rack::ContDataReply{50});
        } else {
          EXPECT_TRUE(mailbox_.reply(header, type::kOk));
        }
      }
      if (listener) send_data(*listener);
      if (replan && refuses_)
        (void)mailbox_.reply(*std::exchange(replan, {}), type::kError, bytes_of("it is closed"));
    }
  }
  template <typename T>
  std::vector<std::byte> encoded(const T& value) {
    std::vector<std::byte> body(rack::encoded_size(value));
    EXPECT_TRUE(rack::encode(value, body));
    return body;
  }
  template <typename T>
  void reply(const Header& header, std::int8_t type, const T& value) {
    EXPECT_TRUE(mailbox_.reply(header, type, encoded(value)));
  }
  void send_data(Address listener) {
    (void)mailbox_.send({.dest = listener, .type = type::kData}, encoded(data_));
  }

  Mailbox mailbox_;
  rack::PathData data_;
  std::atomic<bool> is_asked_ = false;
  std::atomic<bool> refuses_ = false;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

// If the pilot waited for the answer, it would be late with its next command.
TEST_F(PathTest, ThePilotContinuesWhileAPathAroundIsSearched) {
  start_robot();
  start("Scan2dSim", {"--mapFile", plan_with_wall()});
  start("PathRDDF");
  ASSERT_TRUE(turned_on(kPosition));
  ASSERT_TRUE(turned_on(kPath));
  auto maker = proxy<rack::PathProxy>(kPath);
  ASSERT_TRUE(maker.set_rddf(route({{0, 0, 700}, {7000, 0, 700}})));
  ASSERT_TRUE(maker.make({}));
  rack::PathData made;
  ASSERT_TRUE(eventually([&] { return maker.get_data(made) && !made.splines.empty(); }, "a path"));
  PathOfTheTest path(open(*session_, 0x00250100, {.slots = 8}), made);
  auto& pilot = ModulesTest::start(
      "PilotPath", {"--scan2dInst=0", "--maxSpeed=700", "--replanTime=1000", "--pathInst=1"});
  let_drive();
  ASSERT_TRUE(eventually([&] { return path.is_asked(); }, "it stands before the wall", kLong));
  auto status = proxy<rack::PilotProxy>(kPilot);
  for (int look = 0; look < 5; ++look) {
    rack::PilotData data;
    ASSERT_TRUE(status.get_next_data(data, kPatience));
  }
  path.refuse();
  const auto line = pilot.wait_for_line("Path(0/1), REPLAN: it is closed");
  EXPECT_TRUE(line) << line.error().message();
  const std::string all = pilot.standard_error() + pilot.standard_output();
  EXPECT_EQ(all.find("REPLAN: "), all.find("REPLAN: it is closed")) << all;
}

rack::PlannerCommand tasks(const std::vector<std::string>& texts) {
  rack::PlannerCommand command;
  for (const std::string& text : texts) command.commands.push_back(rack::PlannerString::of(text));
  return command;
}

TEST_F(PathTest, ExecutesTasksInOrder) {
  start_robot();
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1"});
  start("Planner");
  ASSERT_TRUE(turned_on("Planner(0/0)"));
  auto planner = proxy<rack::PlannerProxy>("Planner(0/0)");
  const auto wrong = planner.send_command(tasks({"goto 1000 0", "fly"}));
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message().find("\"fly\" is not a task"), std::string::npos);
  ASSERT_TRUE(planner.send_command(tasks({"goto 1500 0", "wait 0.1", "goto 1500 1200 90 600"})));
  const auto ends = [&](int state) {
    return eventually(
        [&]() -> std::string {
          const auto data = planner.get_data();
          if (!data) return data.error().message();
          std::string found = "state " + std::to_string(data->state);
          for (const auto& message : data->messages)
            found += ", " + std::string(message.text.view());
          return data->state == state ? "" : found;
        },
        kLong);
  };
  EXPECT_TRUE(ends(1));
  // A component that crashes during the drive is restarted, and the task continues.
  kill("Position");
  start("Position");
  EXPECT_TRUE(ends(0));
  EXPECT_TRUE(comes_to(1500, 1200));
  ASSERT_TRUE(planner.send_command(tasks({"goto 900000 0"})));
  EXPECT_TRUE(ends(2)) << "outside of the area of the planner";
  // An empty list stops it.
  ASSERT_TRUE(planner.send_command(tasks({"goto 9000 1200"})));
  EXPECT_TRUE(comes_to(2500, 1200));
  ASSERT_TRUE(planner.send_command({}));
  auto chassis = proxy<rack::ChassisProxy>(kChassis);
  EXPECT_TRUE(eventually(
      [&] {
        const auto data = chassis.get_data();
        return data && data->vx == 0.0F;
      },
      "standing"));
}

// The vehicle was carried away: its localisation has detected this, searches, and finds the
// position.
TEST_F(PathTest, StopsWhileItsPositionIsUncertain) {
  start_robot({"--startDeviation=0"});
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1", "--deviationMax=500"});
  let_drive();
  ASSERT_TRUE(proxy<rack::PathProxy>(kPath).set_rddf(route({{0, 0, 700}, {5000, 0, 700}})));
  ASSERT_TRUE(proxy<rack::PathProxy>(kPath).make({}));
  ASSERT_TRUE(comes_to(1000, 0));
  auto position = proxy<rack::PositionProxy>(kPosition);
  auto known = position.get_data();
  ASSERT_TRUE(known) << known.error().message();
  known->var.x = 5000;
  ASSERT_TRUE(position.update(*known));
  ASSERT_TRUE(drives(false));
  known = position.get_data();
  ASSERT_TRUE(known);
  known->pos = {.x = 500, .y = 300, .rho = known->pos.rho};  // behind its old position
  known->var.x = 50;
  ASSERT_TRUE(position.update(*known));
  ASSERT_TRUE(drives(true));
  EXPECT_TRUE(comes_to(5000, 0));
}

TEST_F(PathTest, StopsWithoutAPathAndContinuesWithTheNext) {
  start_robot();
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1"});
  let_drive();
  const auto onward = [&] {
    auto path = proxy<rack::PathProxy>(kPath);
    return path.set_rddf(route({{0, 0, 700}, {5000, 0, 700}})).ok() && path.make({}).ok();
  };
  ASSERT_TRUE(onward());
  ASSERT_TRUE(comes_to(1000, 0));
  kill("PathRDDF");
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(drives(false));
  EXPECT_LT(std::chrono::steady_clock::now() - began, kSlowdown * 900ms)
      << "it stops before it gives up";
  start("PathRDDF");
  ASSERT_TRUE(turned_on(kPath));
  ASSERT_TRUE(onward());
  ASSERT_TRUE(drives(true));
  EXPECT_TRUE(comes_to(5000, 0));
}

TEST_F(PathTest, ThePilotOfTheExampleArrivesToo) {
  start_robot();
  start_eyes();
  start("PilotLab", {"--scan2dInst=0"});
  let_drive();
  auto pilot = proxy<rack::PilotProxy>(kPilot);
  rack::PilotDestData goal;
  goal.pos.x = 1500;
  goal.pos.y = -500;
  ASSERT_TRUE(pilot.set_destination(goal));
  EXPECT_TRUE(comes_to(1500, -500));
}

TEST_F(PathTest, RefusesParametersThatBrakeTooLate) {
  start("ChassisSim", {"--vxMax=4000", "--decMax=1000", "--breakConstant=100"});
  start("OdometryChassis");
  start("Position");
  start_eyes();
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=0"});
  rack::Proxy pilot(*work_, *Address::parse(kPilot));
  std::string why;
  EXPECT_TRUE(eventually(
      [&] {
        const auto on = pilot.on();
        why = on ? "" : on.error().message();
        return why.find("breakConstant") != std::string::npos;
      },
      "the reason why it does not go on"))
      << why;
}

}  // namespace path_test
}  // namespace tims::test
