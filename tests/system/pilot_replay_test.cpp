// A simulated robot drives and stops before an obstacle. A replay of its recording repeats all
// decisions bit for bit and shows the reason of the stop.
#include <fstream>
#include <sstream>

#include <boost/json.hpp>
#include <gmock/gmock.h>

#include "rack/proxies/path.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace pilot_replay_test {

constexpr const char* kPilot = "Pilot(0/0)";

class PilotReplayTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    start("ChassisSim", {"--omegaMax=90", "--periodTime=50", "--acceleration=1", "--vxMax=1000",
                         "--accMax=1000", "--decMax=1000"});
    start("OdometryChassis");
    start("Position");
    start("PathRDDF");
    start("Scan2dSim", {"--mapFile", file("plan.dxf")});
    start("PilotPath",
          {"--scan2dInst=0", "--maxSpeed=700", "--record", recording_, "--replanTime=0"});
    ASSERT_TRUE(turned_on("Position(0/0)"));
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    ASSERT_TRUE(
        proxy<rack::ChassisProxy>("Chassis(0/0)").set_active_pilot(*Address::parse(kPilot)));
    ASSERT_TRUE(turned_on(kPilot));
  }

  // The floor plan with a wall across its corridor that the path does not know.
  std::string file(const std::string& name) {
    std::ifstream plan(FLOOR_PLAN);
    std::string text((std::istreambuf_iterator<char>(plan)), {});
    const std::string wall =
        "  0\nLINE\n  8\n1\n 10\n-1.5\n 20\n3.0\n 11\n1.5\n 21\n3.0\n  0\nENDSEC\n  0\nEOF\n";
    const auto end = text.rfind("ENDSEC");
    text = text.substr(0, text.rfind('0', end)) + wall.substr(wall.find('0'));
    std::string path = (folder_.path() / name).string();
    std::ofstream(path) << text;
    return path;
  }
  void drive_along_the_corridor() {
    rack::PathRddfData route;
    for (const int x : {0, 7000}) {
      rack::Waypoint2d waypoint;
      waypoint.x = x;
      waypoint.speed = 700;
      route.waypoints.push_back(waypoint);
    }
    auto path = proxy<rack::PathProxy>("Path(0/0)");
    ASSERT_TRUE(path.set_rddf(route));
    ASSERT_TRUE(path.make({}));
  }
  testing::AssertionResult has_speed(bool wanted) {
    auto pilot = proxy<rack::PilotProxy>(kPilot);
    return eventually(
        [&] {
          const auto status = pilot.get_status();
          return status && (wanted ? status->speed > 200 : status->speed == 0);
        },
        wanted ? "it drives" : "it stands", 3 * kPatience);
  }

  struct ReplayOutput {
    int status = -1;
    boost::json::value json;
    std::string text;
  };
  ReplayOutput replay(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/pilot-replay");
    auto child = ChildProcess::start(std::move(arguments));
    EXPECT_TRUE(child) << child.error().message();
    const auto ended = child->wait();
    EXPECT_TRUE(ended && ended->signal == 0) << child->output();
    ReplayOutput output{.status = ended ? ended->code : -1, .json = {}, .text = child->output()};
    if (output.text.starts_with("{")) output.json = boost::json::parse(child->standard_output());
    return output;
  }

  const TemporaryFolder folder_;
  const std::string recording_ = (folder_.path() / "drive.cap").string();
};

TEST_F(PilotReplayTest, RepeatsItsDecisionsAndReportsWhyItStopped) {
  drive_along_the_corridor();
  ASSERT_TRUE(has_speed(true));
  auto pilot = proxy<rack::PilotProxy>(kPilot);
  ASSERT_TRUE(pilot.hold_command({1, 0, {}}));
  ASSERT_TRUE(has_speed(false));
  ASSERT_TRUE(pilot.hold_command({0, 0, {}}));
  ASSERT_TRUE(has_speed(true));
  ASSERT_TRUE(has_speed(false)) << "before the wall";
  ASSERT_TRUE(pilot.off());  // and on again: the recording continues
  ASSERT_TRUE(eventually(
      [&] {
        const auto status = pilot.status();
        return status && *status == rack::Status::kDisabled;
      },
      "it is off"));
  ASSERT_TRUE(turned_on(kPilot));
  ASSERT_TRUE(pilot.off());

  // OFF is answered before the end of the recording is written.
  ReplayOutput same;
  ASSERT_TRUE(eventually([&]() -> std::string {
    same = replay({recording_, "--json"});
    return same.status == 0 && same.json.at("begins").as_int64() == 2 ? "" : same.text;
  }));
  EXPECT_EQ(same.json.at("different").as_int64(), 0);
  EXPECT_EQ(same.json.at("undecided").as_int64(), 0);
  EXPECT_EQ(same.json.at("unreadable_lines").as_int64(), 0);
  EXPECT_GT(same.json.at("decisions").as_int64(), 60);
  const ReplayOutput why = replay({recording_, "--why"});
  EXPECT_EQ(why.status, 0);
  EXPECT_THAT(why.text, testing::HasSubstr("stops: an obstacle, free distance"));
  EXPECT_THAT(why.text, testing::HasSubstr("held by HOLD"));
  EXPECT_THAT(why.text, testing::HasSubstr(" decisions: 0 different"));

  const ReplayOutput slower = replay({recording_, "--set", "maxSpeed=400"});
  EXPECT_EQ(slower.status, 1) << slower.text;
  EXPECT_THAT(slower.text, testing::HasSubstr("mm/s"));
  EXPECT_THAT(slower.text, testing::HasSubstr("points of a scan"));
  EXPECT_EQ(replay({recording_, "--set", "nonsense=400"}).status, 2);
  EXPECT_EQ(replay({recording_ + "x"}).status, 4);
  EXPECT_EQ(replay({file("plan.cap")}).status, 1);
}

}  // namespace pilot_replay_test
}  // namespace tims::test
