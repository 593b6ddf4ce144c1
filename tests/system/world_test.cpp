// A simulated world with real drivers at its devices, and components that use them: their estimates
// agree with the ground truth, and the world continues when programs crash.
#include "rack/proxies/world.h"

#include <cmath>
#include <fstream>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace world_test {

namespace json = boost::json;
using testing::HasSubstr;
using namespace std::chrono_literals;

// The floor plan of the sample robots, with a Pioneer that has a SICK LMS200.
constexpr std::string_view kWorldFile = R"(
seed = 3

[[plan]]
file = "PLAN"

[people]
count = 2
avoids = 1.0
from = [20000, 20000]
to = [24000, 24000]

[[robot]]
name = "scout"
at = [0, 0, 0]
track = 400
front = 250
back = 250
left = 200
right = 200
slip = { distance = 0.01, turn = 0.01, distance_noise = 5 }
device = "pioneer"
line = "pty:FOLDER/pioneer"

[[robot.sensor]]
name = "laser"
kind = "scanner"
at = [160, 0, 0]
height = 200
range = 8000
noise = { range = 10 }
device = "lms200"
line = "pty:FOLDER/lms200"
)";

class WorldTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    write(kWorldFile);
    start("World", {"--file=" + file(), "--period=20"});
    ASSERT_TRUE(turned_on("World(0/0)"));
    start("ChassisPioneer", {"--device=serial:" + in_folder("pioneer")});
  }

  [[nodiscard]] std::string in_folder(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  [[nodiscard]] std::string file() const { return in_folder("world.toml"); }
  void write(std::string_view content) {
    std::string text(content);
    for (const auto& [what, with] : {std::pair<std::string, std::string>{"PLAN", FLOOR_PLAN},
                                     {"FOLDER", folder_.path().string()}})
      for (auto at = text.find(what); at != std::string::npos; at = text.find(what))
        text.replace(at, what.size(), with);
    std::ofstream(file()) << text;
  }

  rack::WorldProxy world() { return proxy<rack::WorldProxy>("World(0/0)"); }
  rack::ChassisProxy chassis() { return proxy<rack::ChassisProxy>("Chassis(0/0)"); }
  rack::WorldThing scout() {
    const auto truth = world().get_data();
    EXPECT_TRUE(truth) << truth.error().message();
    const auto* const found = truth ? truth->find(rack::world_thing::kRobot, "scout") : nullptr;
    return found != nullptr ? *found : rack::WorldThing{};
  }

  testing::AssertionResult becomes(const std::function<bool(const rack::WorldThing&)>& so,
                                   const std::string& what) {
    return eventually([&]() -> std::string {
      const auto is = scout();
      return so(is) ? ""
                    : what + ": it is at " + std::to_string(is.pos.x.raw()) + ", " +
                          std::to_string(is.pos.y.raw()) + " with " + std::to_string(is.vx.raw()) +
                          " mm/s";
    });
  }
  // Makes the test the active pilot. Selecting a pilot stops a chassis.
  void turn_on_chassis() {
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    ASSERT_TRUE(chassis().set_active_pilot(Address(kWork)).ok());
  }
  testing::AssertionResult drives() {
    return eventually([&]() -> std::string {
      if (auto moved = chassis().move(200, 0, 0); !moved) return moved.error().message();
      return scout().vx > 100 ? "" : "it does not drive";
    });
  }

  struct Ran {
    int code = -1;
    std::string out;
    std::string err;
  };
  Ran timsctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/timsctl");
    auto child = ChildProcess::start(std::move(arguments), at_router());
    EXPECT_TRUE(child) << child.error().message();
    if (!child) return {};
    const auto status = child->wait();
    return {status ? status->code : -1, child->standard_output(), child->standard_error()};
  }

  TemporaryFolder folder_;
};

TEST_F(WorldTest, ARobotFollowsWallsByItsSensorsWithoutContact) {
  start("LadarSickLms200", {"--device=serial:" + in_folder("lms200"), "--baudrate=38400"});
  start("OdometryChassis");
  start("Scan2d", {"--ladarInst=0", "--ladarOffsetX=160", "--maxRange=8000"});
  start("Position");
  start("PilotWallFollowing", {"--scan2dInst=0", "--maxSpeed=400"});
  ASSERT_TRUE(turned_on("Chassis(0/0)"));
  ASSERT_TRUE(chassis().set_active_pilot(*Address::parse("Pilot(0/0)")).ok());
  ASSERT_TRUE(turned_on("Pilot(0/0)"));
  ASSERT_TRUE(
      becomes([](const auto& is) { return is.travelled > 3000; }, "it drives along a wall"));

  auto odometry = proxy<rack::OdometryProxy>("Odometry(0/0)");
  const auto reckoned = odometry.get_data();
  ASSERT_TRUE(reckoned) << reckoned.error().message();
  const auto truth = world().get_data(reckoned->recordingTime);
  ASSERT_TRUE(truth) << truth.error().message();
  const auto* const is = truth->find(rack::world_thing::kRobot, "scout");
  ASSERT_NE(is, nullptr);
  EXPECT_EQ(is->contacts(), 0U);
  EXPECT_EQ(is->isBlocked, 0);
  // It started at 0, 0; the error of the odometry is due to wheel slip.
  const double travelled = is->travelled.raw();
  EXPECT_NEAR(reckoned->pos.x.raw(), is->pos.x.raw(), 100 + travelled * 0.05);
  EXPECT_NEAR(reckoned->pos.y.raw(), is->pos.y.raw(), 100 + travelled * 0.05);
}

TEST_F(WorldTest, ContinuesWhenADriverIsKilled) {
  turn_on_chassis();
  ASSERT_TRUE(drives());
  kill("ChassisPioneer");
  const auto before = world().get_data();
  ASSERT_TRUE(becomes([](const auto& is) { return is.vx == 0; }, "it stops"));
  const auto stands = scout();
  const auto after = world().get_data();
  ASSERT_TRUE(before && after);
  EXPECT_GT(after->recordingTime, before->recordingTime) << "simulated time continues";

  start("ChassisPioneer", {"--device=serial:" + in_folder("pioneer")});
  turn_on_chassis();
  const auto still = scout();
  EXPECT_EQ(still.pos.x, stands.pos.x);
  EXPECT_EQ(still.travelled, stands.travelled);
  ASSERT_TRUE(drives());
  EXPECT_GT(scout().travelled, stands.travelled) << "it continues from there";
}

TEST_F(WorldTest, ACollisionWithAPostStopsTheRobotAndIsCounted) {
  turn_on_chassis();
  const auto post = world().put({.pos = {.x = 800, .y = 0}, .radius = 150});
  ASSERT_TRUE(post) << post.error().message();
  ASSERT_TRUE(eventually([&]() -> std::string {
    (void)chassis().move(200, 0, 0);
    return scout().isBlocked != 0 ? "" : "it does not touch the post";
  }));
  const auto at = scout();
  EXPECT_EQ(at.obstacles, 1U);
  EXPECT_NEAR(at.pos.x.raw(), 800 - 150 - 250, 15);
  EXPECT_EQ(at.vx.raw(), 0);
  ASSERT_TRUE(world().remove(post->id).ok());
  EXPECT_TRUE(drives());
  EXPECT_FALSE(world().remove(post->id).ok()) << "it was removed";
}

TEST_F(WorldTest, AnUnpluggedLaserIsReportedAndRecovers) {
  start("LadarSickLms200", {"--device=serial:" + in_folder("lms200"), "--baudrate=38400"});
  ASSERT_TRUE(turned_on("Ladar(0/0)"));
  auto ladar = proxy<rack::LadarProxy>("Ladar(0/0)");
  ASSERT_TRUE(world().plug("scout", "laser", false).ok());
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto state = ladar.status();
    return state && *state == rack::Status::kError ? "" : "the driver has not noticed";
  }));
  ASSERT_TRUE(world().plug("scout", "laser", true).ok());
  EXPECT_TRUE(turned_on("Ladar(0/0)"));
}

TEST_F(WorldTest, TimsctlShowsAndChangesIt) {
  const auto placed = timsctl({"world", "place", "scout", "1.5m", "500", "1.57"});
  EXPECT_EQ(placed.code, 0) << placed.err;
  EXPECT_TRUE(becomes([](const auto& is) { return is.pos.x == 1500 && is.pos.y == 500; },
                      "it was put elsewhere"));
  const auto put = timsctl({"world", "put", "3000", "500", "200"});
  EXPECT_EQ(put.code, 0) << put.err;
  EXPECT_EQ(timsctl({"world", "put", "1500", "500", "200"}).code, 1) << "the robot is there";
  EXPECT_EQ(timsctl({"world", "unplug", "scout", "laser"}).code, 0);
  EXPECT_EQ(timsctl({"world", "people", "off"}).code, 0);
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto truth = world().get_data();
    return truth && truth->peopleMove == 0 ? "" : "people walk";
  }));

  const auto shown = timsctl({"world", "show", "--json"});
  ASSERT_EQ(shown.code, 0) << shown.err;
  const json::object answer = json::parse(shown.out).as_object();
  EXPECT_EQ(answer.at("schema"), "tims/world/1");
  EXPECT_EQ(answer.at("people_move"), false);
  const json::array& items = answer.at("items").as_array();
  ASSERT_EQ(items.size(), 4U) << "a robot, two people, a post";
  EXPECT_EQ(items[0].at("name"), "scout");
  EXPECT_EQ(items[0].at("unplugged"), "laser");
  EXPECT_EQ(items[3].at("kind"), "obstacle");
  EXPECT_THAT(timsctl({"world"}).out, HasSubstr("scout"));

  EXPECT_EQ(timsctl({"world", "plug", "scout", "laser"}).code, 0);
  EXPECT_EQ(timsctl({"world", "remove", std::to_string(items[3].at("id").as_int64())}).code, 0);
  const auto wrong = timsctl({"world", "place", "nobody", "0", "0"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("there are: scout"));
  EXPECT_THAT(timsctl({"world", "unplug", "scout", "tail"}).err, HasSubstr("base laser"));
  EXPECT_EQ(timsctl({"__complete", "world", "unplug", "scout", ""}).out, "base\nlaser\n");
  EXPECT_THAT(timsctl({"msg", "echo", "World/0/0", "-n", "1", "--json"}).out,
              HasSubstr("\"name\":\"scout\""));
}

TEST_F(WorldTest, AnErrorInAFileIsReportedWithItsLine) {
  write("[[robot]]\nname = \"scout\"\nat = [0, 0]\n");
  kill("World");
  start("World", {"--file=" + file()});
  rack::Proxy component(*work_, *Address::parse("World(0/0)"));
  const auto on = component.on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("world.toml:3"));
}

}  // namespace world_test
}  // namespace tims::test
