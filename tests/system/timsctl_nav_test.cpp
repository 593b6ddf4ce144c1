// timsctl nav: shows the position of a simulated robot, and sends it to destinations.
#include <filesystem>
#include <fstream>
#include <iterator>

#include <boost/json/serialize.hpp>

#include "rack/proxies/position.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_nav_test {

class TimsctlNavTest : public RobotTest {
 protected:
  void start_robot() {
    start("ChassisSim", {"--omegaMax=90", "--periodTime=50", "--acceleration=1", "--vxMax=1000",
                         "--accMax=1000", "--decMax=1000"});
    start("OdometryChassis");
    start("Position", {"--startDeviation=0"});
  }
  void start_pilot(const std::vector<std::string>& of_path = {}) {
    std::vector<std::string> arguments = {"--cellSize=50"};
    arguments.insert(arguments.end(), of_path.begin(), of_path.end());
    start("PathRDDF", arguments);
    start("PilotPath", {"--scan2dInst=-1", "--maxSpeed=700"});
  }
  Result<ChildProcess> begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {TIMSCTL_PROGRAM, "nav"});
    arguments.push_back("--timeout=" + std::to_string(kPatienceMs) + "ms");
    return ChildProcess::start(std::move(arguments),
                               {.environment = {"TIMS_ROUTER=" + router_.socket_path(),
                                                "TIMS_HOST=", "TERM=xterm", "NO_COLOR="},
                                .folder = {}});
  }
  Ran nav(std::vector<std::string> arguments) { return finish(begin(std::move(arguments))); }
  json::object nav_json(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const auto lines = json_lines(nav(std::move(arguments)).out);
    return lines.empty() ? json::object() : lines.back();
  }
};

TEST_F(TimsctlNavTest, ShowsThePositionAndWhatIsMissing) {
  const Ran nobody = nav({"where"});
  EXPECT_EQ(nobody.code, 4);
  EXPECT_THAT(nobody.err, HasSubstr("no component of a robot is registered"));
  start_robot();
  const Ran off = nav({"where"});
  EXPECT_EQ(off.code, 1);
  EXPECT_THAT(off.out, HasSubstr("unknown: Position(0/0) is off\n"));
  EXPECT_THAT(off.out, HasSubstr("  -> `timsctl component on Position/0/0`\n"));
  ASSERT_TRUE(turned_on("Position(0/0)"));
  const Ran on = nav({"where", "0"});
  EXPECT_EQ(on.code, 0) << on.err;
  EXPECT_THAT(on.out, HasSubstr("x 0.00 m, y 0.00 m, heading 0.0 deg\n"));
  EXPECT_THAT(on.out, HasSubstr("there is no MonteCarloLocalisation"));
  EXPECT_THAT(on.out, Not(HasSubstr("On Earth")));
  EXPECT_EQ(nav({"where", "7"}).code, 4);
  ASSERT_TRUE(turned_on("Position(0/0)"));

  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("MonteCarloLocalisation", {"--positionInst=0", "--period=200", "--maxRange=10000"});
  EXPECT_THAT(nav({"where"}).out, HasSubstr("`timsctl nav map load FILE`"));
  const Ran loaded = nav({"map", "load", FLOOR_PLAN});
  EXPECT_EQ(loaded.code, 0) << loaded.err;
  EXPECT_THAT(loaded.out, HasSubstr("loaded"));
  EXPECT_EQ(nav({"map", "load", "/nowhere/floor.dxf"}).code, 1);
  EXPECT_THAT(nav({"map"}).out, HasSubstr(FLOOR_PLAN)) << "the map that it had loaded";
  ASSERT_TRUE(turned_on("Mcl(0/0)"));
  EXPECT_TRUE(eventually([&]() -> std::string {
    const json::object answer = nav_json({"where"});
    if (!answer.contains("localisation")) return json::serialize(answer);
    const auto& part = answer.at("localisation").as_object();
    return part.contains("samples") && answer.at("missing").as_array().empty()
               ? ""
               : json::serialize(answer);
  }));
}

TEST_F(TimsctlNavTest, DrivesToADestinationOnTheMap) {
  start_robot();
  start_pilot({"--mapFile", FLOOR_PLAN});
  const Ran there = nav({"goto", "3.5", "6", "172"});
  EXPECT_EQ(there.code, 0) << there.err << there.out;
  EXPECT_THAT(there.out, HasSubstr("driving "));
  EXPECT_THAT(there.out, HasSubstr("arrived at x 3."));
  const auto at = proxy<rack::PositionProxy>("Position(0/0)").get_data();
  ASSERT_TRUE(at.ok());
  EXPECT_NEAR(at->pos.x.raw(), 3500, 150);
  EXPECT_NEAR(at->pos.y.raw(), 6000, 150);
  EXPECT_NEAR(static_cast<double>(at->pos.rho), 3.0, 0.2);

  const json::object path = nav_json({"path"});
  EXPECT_EQ(path.at("schema").as_string(), "tims/nav_path/1");
  EXPECT_GT(path.at("length_m").to_number<double>(), 6);
  EXPECT_GT(path.at("seconds").to_number<double>(), 6);
  EXPECT_THAT(nav({"path"}).out, HasSubstr("arc to the "));
  const TemporaryFolder folder;
  const std::string picture = folder.path() / "path.svg";
  EXPECT_EQ(nav({"path", "--plot", picture}).code, 0);
  std::ifstream file(picture);
  const std::string svg((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(svg, HasSubstr(">path</text>"));
  EXPECT_THAT(svg, HasSubstr(">robot 0</text>"));
  EXPECT_THAT(svg, HasSubstr(">map</text>")) << "from the file of the path";
  EXPECT_EQ(nav({"path", "--plot", "path.gif"}).code, 2);

  const Ran walled = nav({"goto", "1.5", "6"});
  EXPECT_EQ(walled.code, 1);
  EXPECT_THAT(walled.err, HasSubstr("no room"));
  EXPECT_EQ(nav({"goto", "here", "6"}).code, 2);
  EXPECT_EQ(nav({"goto", "1e9", "6"}).code, 2);
  const Ran sent = nav({"goto", "0", "0", "--no-wait"});
  EXPECT_EQ(sent.code, 0) << sent.err;
  EXPECT_THAT(sent.out, HasSubstr("sent to x 0.00 m, y 0.00 m"));
}

// A robot file names "floor.dxf", and its components run in the folder of the file.
TEST_F(TimsctlNavTest, DrawsTheMapOfARobotThatRunsInAnotherFolder) {
  namespace fs = std::filesystem;
  const TemporaryFolder robot;
  const fs::path map = robot.path() / "floor.dxf";
  fs::copy_file(FLOOR_PLAN, map);
  ChildOptions options = at_router();
  options.folder = robot.path();
  auto planner = ChildProcess::start({TIMS_PROGRAMS "/PathRDDF", "--mapFile=floor.dxf"}, options);
  ASSERT_TRUE(planner && planner->wait_for_line("Init"));
  const fs::path picture = robot.path() / "map.svg";
  const Ran drawn = nav({"map", "show", "--plot", picture});
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_THAT(drawn.out, HasSubstr("floor.dxf"));
  std::ifstream file(picture);
  const std::string svg((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(svg, HasSubstr(">map</text>"));

  // A picture without the map is not what was requested.
  fs::remove(map);
  fs::remove(picture);
  const Ran gone = nav({"map", "show", "--plot", picture});
  EXPECT_EQ(gone.code, 1);
  EXPECT_THAT(gone.err, HasSubstr("map.svg was not written: no map of robot 0"));
  EXPECT_THAT(gone.err, HasSubstr(map.string()));
  EXPECT_FALSE(fs::exists(picture));
}

TEST_F(TimsctlNavTest, CtrlCAndTheTimeoutStopIt) {
  start_robot();
  start_pilot();
  const auto stands = [&] {
    const auto data = proxy<rack::ChassisProxy>("Chassis(0/0)").get_data();
    return data && data->vx == 0;
  };
  auto drive = begin({"goto", "15", "0", "--json"});
  ASSERT_TRUE(drive) << drive.error().message();
  const auto driving = drive->wait_for_line("\"driving\"");
  ASSERT_TRUE(driving) << driving.error().message();
  drive->signal(SIGINT);
  const Ran stopped = finish(*drive);
  EXPECT_EQ(stopped.code, 130);
  EXPECT_THAT(stopped.err, HasSubstr("the robot stands still: Pilot(0/0) is stopped"));
  EXPECT_TRUE(stands());

  const Ran late = nav({"goto", "15", "0", "--for", "1s"});
  EXPECT_EQ(late.code, 6) << late.out;
  EXPECT_THAT(late.err, HasSubstr(" m to go"));
  EXPECT_TRUE(stands());

  auto killed = begin({"goto", "15", "0", "--json"});
  ASSERT_TRUE(killed) << killed.error().message();
  ASSERT_TRUE(killed->wait_for_line("\"driving\""));
  killed->signal(SIGKILL);
  EXPECT_TRUE(eventually([&] { return stands() ? "" : "it drives"; }));
  EXPECT_EQ(nav({"goto", "2", "0"}).code, 0) << "another destination";
}

// `timsctl up FILE &` and the next command of a script: one component comes after the other.
TEST_F(TimsctlNavTest, WaitsForARobotThatIsBeingStarted) {
  auto drive = begin({"goto", "1", "0"});
  ASSERT_TRUE(drive) << drive.error().message();
  ASSERT_TRUE(drive->wait_for_line("no component of a robot is registered; waiting"));
  start_robot();
  start_pilot();
  const Ran arrived = finish(*drive);
  EXPECT_EQ(arrived.code, 0) << arrived.err;
  EXPECT_THAT(arrived.out, HasSubstr("arrived at x "));
}

// Another client holds it: it does not move, and after some time this is reported.
TEST_F(TimsctlNavTest, GivesUpWhenItMakesNoProgress) {
  start_robot();
  start_pilot();
  start("PilotWallFollowing", {"--instance=1", "--scan2dInst=0"});
  auto drive = begin({"goto", "15", "0", "--patience", "2s"});
  ASSERT_TRUE(drive) << drive.error().message();
  const auto driving = drive->wait_for_line("driving ");
  ASSERT_TRUE(driving) << driving.error().message();
  ASSERT_TRUE(proxy<rack::PilotProxy>("Pilot(0/0)").hold_command({1, 0, {}}));
  const Ran blocked = finish(*drive);
  EXPECT_EQ(blocked.code, 1);
  EXPECT_THAT(blocked.out, HasSubstr("standing "));
  EXPECT_THAT(blocked.err, HasSubstr("is blocked"));
}

TEST_F(TimsctlNavTest, DrivesToAGeographicDestination) {
  start("ChassisSim", {"--omegaMax=90", "--periodTime=50", "--vxMax=1000"});
  start("OdometryChassis");
  start("Position", {"--positionReference=2", "--autoOffset=1", "--startDeviation=0"});
  start_pilot();
  ASSERT_TRUE(turned_on("Position(0/0)"));
  const Ran nowhere = nav({"goto", "--gps", "52.4", "9.7"});
  EXPECT_EQ(nowhere.code, 1) << "it would take that place for its origin";
  EXPECT_THAT(nowhere.err, HasSubstr("does not know the geographic position of its origin"));
  ASSERT_TRUE(turned_on("Position(0/0)"));
  // The origin follows from the first geographic position; 3e-5 degrees are about three metres.
  rack::PositionWgs84Data place;
  place.latitude = 52.4 * 3.14159265358979 / 180;
  place.longitude = 9.7 * 3.14159265358979 / 180;
  auto position = proxy<rack::PositionProxy>("Position(0/0)");
  const auto first = position.wgs84_to_pos(place);
  ASSERT_TRUE(first.ok());
  rack::PositionData here;
  here.recordingTime = position.get_data()->recordingTime;
  here.pos.x = first->pos.x;
  here.pos.y = first->pos.y;
  ASSERT_TRUE(position.update(here).ok());
  // The planner gets it a moment later.
  json::object there;
  ASSERT_TRUE(eventually([&]() -> std::string {
    there = nav_json({"goto", "--gps", "52.40003", "9.70003"});
    return there.contains("result") ? "" : json::serialize(there);
  }));
  EXPECT_EQ(there.at("result").as_string(), "arrived");
  EXPECT_NEAR(there.at("pose").as_object().at("x_m").to_number<double>(), first->pos.x.si() + 3.3,
              0.4);
  const json::object where = nav_json({"where"});
  EXPECT_NEAR(where.at("latitude_deg").to_number<double>(), 52.40003, 5e-6);
  EXPECT_NEAR(where.at("longitude_deg").to_number<double>(), 9.70003, 5e-6);
  EXPECT_EQ(nav({"goto", "--gps", "95", "9"}).code, 2);
}

TEST_F(TimsctlNavTest, DrawsRecordings) {
  const TemporaryFolder folder;
  const std::string track = folder.path() / "drive.csv";
  const std::string truth = folder.path() / "world.csv";
  const std::string picture = folder.path() / "drive.svg";
  std::ofstream(track) << "time_s,x_m,y_m\n0,0,0\n1,1,0.1\n2,2,0\n";
  std::ofstream(truth) << "time_s,x_m,y_m\n0,0,0\n2,2,0\n";
  const Ran drawn = nav({"plot", picture, FLOOR_PLAN, track, "truth=" + truth});
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("2 trajectories, 1 curves over time"));
  std::ifstream file(picture);
  const std::string svg((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(svg, HasSubstr("estimate: position error"));
  const std::string raster = folder.path() / "drive.png";
  const Ran png = nav({"plot", raster, FLOOR_PLAN, track, "truth=" + truth});
  std::ifstream pixels(raster, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(pixels)), {});
  if (RACK_WITH_OPENCV == 0) {
    EXPECT_EQ(png.code, 1);
    EXPECT_THAT(png.err, HasSubstr("or name it .svg"));
    EXPECT_TRUE(bytes.empty());
  } else {
    EXPECT_EQ(png.code, 0) << png.err;
    EXPECT_THAT(bytes, testing::StartsWith("\x89PNG\r\n"));
  }
  const Ran broken = nav({"plot", picture, "/proc/self/status"});
  EXPECT_EQ(broken.code, 1);
  EXPECT_THAT(broken.err, HasSubstr("/proc/self/status: no columns"));
  EXPECT_EQ(nav({"plot", picture, "/nowhere"}).code, 4);
  EXPECT_EQ(nav({"plot", "drive.jpg", track}).code, 2);
}

}  // namespace timsctl_nav_test
}  // namespace tims::test
