#include "components/world/core/world_file.h"

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/world/core/camera_lens.h"
#include "components/world/core/rooms_fixture.h"

namespace rack::world {
namespace world_file_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::string_view kSquare =
    "0\nLINE\n10\n1\n20\n2\n11\n3\n21\n4\n0\nLINE\n10\n1\n20\n2\n0\nEOF\n";

tims::Result<std::string> square(const std::string& name) {
  if (name == "square.dxf") return std::string(kSquare);
  if (name == "broken.dxf") return std::string("no drawing\n");
  if (name == "maps/hall.yaml") return std::string("image: hall.pgm\nresolution: 0.1\n");
  if (name == "maps/hall.pgm") return std::string("a picture");
  if (name == "maps/none.yaml") return std::string("image: none.pgm\nresolution: 0.1\n");
  return tims::Error(tims::Errc::kSystem, "No such file or directory");
}

// A wall of two cells at the lower border of the picture.
tims::Result<pictures::GreyPicture> decode(std::string_view bytes) {
  EXPECT_EQ(bytes, "a picture");
  return pictures::GreyPicture{.width = 3, .height = 2, .values = {254, 254, 254, 0, 0, 254}};
}

WorldFile read(const std::string& text) { return read_world({"w.toml", text}, square, decode); }

std::vector<std::string> problems(const std::string& text) {
  std::vector<std::string> texts;
  for (const auto& problem : read(text).problems) texts.push_back(problem.to_string());
  return texts;
}

constexpr const char* kEverything = R"(
name = "w"
seed = 42
[ground]
from = [-1000, -2000]
to = [90000, 80000.5]
[origin]
latitude = 37.5
longitude = -122
altitude = 12.5
[[plan]]
file = "square.dxf"
scale = 100
offset = [1, 0.5]
height = 2000
[[wall]]
from = [1, 2]
to = [3, 4]
height = 500
[[obstacle]]
at = [5, 6]
rho = 90
length = 700
width = 300
height = 250
[[obstacle]]
at = [7, 8]
radius = 150
[people]
count = 3
speed = 900
height = 1800
pause = "2s"
avoids = 0.5
from = [0, 0]
to = [9, 9]
[[people.walk]]
places = [[1, 2], [3, 4], [5, 6]]
pause = "9s"
[[robot]]
name = "r"
kind = "double-ackermann"
at = [10, 20, 180]
track = 500
base = 900
steer_max = 30
wheel_radius = 150
gear_ratio = 20
steer_ratio = 30
front = 1
back = 2
left = 3
right = 4
height = 5
acceleration = 6
deceleration = 7
steering_rate = 90
lag = "80ms"
slip = { distance = 0.1, turn = 0.2, distance_noise = 3, turn_noise = 45 }
device = "robucar"
line = "pty:/tmp/x"
[[robot.sensor]]
name = "s"
kind = "satellite"
at = [1, 2, -90]
height = 300
tilt = [10, -20]
range = 8000
noise = { range = 1, short = 0.2, dropped = 0.3, position = 4, drift = 5, angle = 6, rate = 7, rate_bias = 8, acceleration = 9 }
lag = "5ms"
outages = ["10s to 1min"]
period = "2s"
device = "nmea"
line = "tcp:localhost:1"
[[robot.sensor]]
name = "t"
kind = "scanner"
axis = { about = "pitch", gear_ratio = 10, device = "servo", line = "pty:/tmp/y" }
)";

TEST(WorldFile, OnlyScannersHaveAnAxisAndItMustBeComplete) {
  const std::string robot =
      "[[robot]]\nname = \"r\"\nat = [0, 0, 0]\n[[robot.sensor]]\nname = \"s\"\n";
  EXPECT_THAT(problems(robot + "kind = \"compass\"\naxis = { about = \"yaw\" }\n"),
              ElementsAre(HasSubstr("s: only scanners have an axis")));
  EXPECT_THAT(problems(robot + "kind = \"scanner\"\naxis = { gear_ratio = 2 }\n"),
              ElementsAre(HasSubstr("about is missing")));
  EXPECT_THAT(problems(robot + "kind = \"scanner\"\naxis = { about = \"pitsch\" }\n"),
              ElementsAre(HasSubstr("pitch")));
}

TEST(WorldFile, ReadsEverything) {
  const WorldFile file = read(kEverything);
  ASSERT_THAT(file.problems, IsEmpty());
  const WorldDescription& world = file.description;
  EXPECT_EQ(world.name, "w");
  EXPECT_EQ(world.seed, 42U);
  EXPECT_EQ(world.ground.to.y, 80000.5);
  EXPECT_NEAR(degrees(world.origin.longitude), -122, 1e-9);
  EXPECT_EQ(world.origin.altitude, 12.5);
  ASSERT_EQ(world.walls.size(), 2U);
  EXPECT_EQ(world.walls[0].from.x, 100);
  EXPECT_EQ(world.walls[0].from.y, 50);
  EXPECT_EQ(world.walls[0].to.x, 300);
  EXPECT_EQ(world.walls[0].height, 2000);
  EXPECT_EQ(world.walls[1].to.y, 4);
  EXPECT_THAT(file.remarks, ElementsAre("square.dxf, line 11: LINE without an end"));
  ASSERT_EQ(world.obstacles.size(), 2U);
  EXPECT_EQ(world.obstacles[0].shape, Shape::kBox);
  EXPECT_NEAR(world.obstacles[0].rho, kPi / 2, 1e-9);
  EXPECT_EQ(world.obstacles[1].shape, Shape::kCircle);
  EXPECT_EQ(world.obstacles[1].radius, 150);
  EXPECT_EQ(world.people.count, 3U);
  EXPECT_EQ(world.people.pause_max, std::chrono::seconds(2));
  ASSERT_TRUE(world.people.area);
  EXPECT_EQ(world.people.area->to.x, 9);
  ASSERT_EQ(world.people.walks.size(), 1U);
  EXPECT_EQ(world.people.walks[0].pause, std::chrono::seconds(9));
  ASSERT_EQ(world.people.walks[0].places.size(), 3U);
  EXPECT_EQ(world.people.walks[0].places[2].y, 6);
  ASSERT_EQ(world.robots.size(), 1U);
  const RobotDescription& robot = world.robots[0];
  EXPECT_EQ(robot.kind, DriveKind::kDoubleAckermann);
  EXPECT_NEAR(robot.start.rho, kPi, 1e-9);
  EXPECT_NEAR(robot.steer_max, radians(30), 1e-9);
  EXPECT_NEAR(robot.steering_rate, kPi / 2, 1e-9);
  EXPECT_EQ(robot.gear_ratio, 20);
  EXPECT_EQ(robot.right, 4);
  EXPECT_EQ(robot.deceleration, 7);
  EXPECT_EQ(robot.lag, std::chrono::milliseconds(80));
  EXPECT_NEAR(robot.slip.turn_noise, kPi / 4, 1e-9);
  EXPECT_EQ(robot.line, "pty:/tmp/x");
  ASSERT_EQ(robot.sensors.size(), 2U);
  const AxisDescription& axis = robot.sensors[1].axis;
  EXPECT_EQ(axis.about, TurnedAbout::kPitch);
  EXPECT_EQ(axis.gear_ratio, 10);
  EXPECT_EQ(axis.device, "servo");
  EXPECT_EQ(axis.line, "pty:/tmp/y");
  const SensorDescription& sensor = robot.sensors[0];
  EXPECT_EQ(sensor.kind, SensorKind::kSatellite);
  EXPECT_EQ(sensor.mount.z, -300);
  EXPECT_NEAR(sensor.mount.psi, radians(-20), 1e-9);
  EXPECT_NEAR(sensor.mount.rho, -kPi / 2, 1e-9);
  EXPECT_EQ(sensor.noise.dropped_share, 0.3);
  EXPECT_NEAR(sensor.noise.rate_bias, radians(8), 1e-9);
  EXPECT_EQ(sensor.outages[0].to, std::chrono::minutes(1));
  EXPECT_EQ(sensor.period, std::chrono::seconds(2));
  EXPECT_EQ(sensor.device, "nmea");
}

TEST(WorldFile, EveryProblemHasItsPlace) {
  EXPECT_THAT(problems("name = 1\nspeed = 3\n"),
              ElementsAre("w.toml:1:8: name must be a text in quotes, not 1",
                          HasSubstr("w.toml:2:1: unknown key of a world \"speed\"")));
  EXPECT_THAT(problems("[[robot]]\nname = \"a\"\nat = [1, 2, 3]\nslip = { way = 2 }\n"),
              ElementsAre("w.toml:4:16: distance must be a number from -0.5 to 0.5, not 2"));
  EXPECT_THAT(
      problems("[[robot]]\nkind = \"car\"\nat = [1, 2]\nlag = 5\nslip = { distance = 2 }\n"),
      ElementsAre("w.toml:1:1: name is missing",
                  HasSubstr("w.toml:2:8: unknown kind of robot \"car\"; "),
                  HasSubstr("w.toml:3:6: at must be a pose such as"),
                  "w.toml:4:7: lag must be a duration such as \"5s\", not 5",
                  "w.toml:5:21: distance must be a number from -0.5 to 0.5, not 2"));
  EXPECT_THAT(
      problems("[[plan]]\nfile = \"none.dxf\"\n[[plan]]\nfile = \"broken.dxf\"\n[[plan]]\n"),
      ElementsAre("w.toml:2:8: none.dxf: No such file or directory",
                  "w.toml:4:8: broken.dxf: line 1: no group code", "w.toml:5:1: file is missing"));
  EXPECT_THAT(problems("[[plan]]\nfile = \"square.dxf\"\nscale = 1e6\noffset = [900, 0]\n"),
              ElementsAre(HasSubstr("w.toml:2:8: has walls 898000 m away; scale is")));
  EXPECT_THAT(problems("[[obstacle]]\nat = [1, nan]\nradius = 5\nwidth = 5\n[[obstacle]]\n"),
              ElementsAre(HasSubstr("w.toml:1:1: an obstacle has a radius, or"),
                          HasSubstr("w.toml:2:10: an item must be a number from -1"),
                          "w.toml:5:1: at is missing"));
  EXPECT_THAT(problems("[people]\ncount = 201\nfrom = [5, 5]\nto = [5, 9]\n"),
              ElementsAre(HasSubstr("w.toml:1:2: from must be the corner"),
                          "w.toml:2:9: count must be a number from 0 to 200, not 201"));
  EXPECT_THAT(problems("[[people.walk]]\nplaces = [[1, 2]]\n[[people.walk]]\npause = \"1s\"\n"
                       "[[people.walk]]\nplaces = [[1, 2], [3]]\n"),
              ElementsAre(HasSubstr("w.toml:2:10: places must contain 2 to 10 of them"),
                          "w.toml:3:1: places is missing",
                          HasSubstr("w.toml:6:19: an item must be a place such as")));
  const std::string robot = "[[robot]]\nname = \"a\"\nat = [0, 0, 0]\n";
  EXPECT_THAT(problems(robot + robot), ElementsAre("w.toml:4:1: there is another robot a"));
  EXPECT_THAT(problems(robot + "[[robot.sensor]]\nname = \"s\"\nkind = \"compass\"\n"
                               "outages = [\"5s\", \"9s to 8s\"]\n"),
              ElementsAre(HasSubstr("w.toml:7:12: outages must be times"),
                          HasSubstr("w.toml:7:18: outages must be times")));
  const std::string sensor = robot + "[[robot.sensor]]\nname = \"s\"\nkind = ";
  EXPECT_THAT(problems(sensor + "\"scanner\"\nperiod = \"2s\"\n"),
              ElementsAre("w.toml:4:1: s: only satellite receivers have a period"));
  EXPECT_THAT(problems(sensor + "\"satellite\"\nperiod = \"2min\"\n"),
              ElementsAre("w.toml:4:1: s: period is from 50ms to 1min"));
  EXPECT_THAT(problems("x = \n"), ElementsAre(HasSubstr("w.toml:1:")));
}

TEST(WorldFile, HasCameras) {
  const std::string robot = "[[robot]]\nname = \"r\"\nat = [0, 0, 0]\n[[robot.sensor]]\n";
  const std::string camera = robot + "name = \"c\"\nkind = \"camera\"\n";
  const auto sensor_of = [](const std::string& text) {
    const WorldFile file = read(text);
    EXPECT_THAT(file.problems, IsEmpty()) << file.problems.front().to_string();
    return file.description.robots.at(0).sensors.at(0);
  };
  const SensorDescription usual = sensor_of(camera);
  EXPECT_EQ(usual.camera.width, 640);
  EXPECT_NEAR(usual.camera.focal, 554.26, 0.01) << "60 degrees";
  EXPECT_NEAR(std::chrono::duration<double>(usual.period).count(), 1 / 15.0, 1e-6);
  const SensorDescription other =
      sensor_of(camera +
                "size = [16, 1920]\nfocal = 900\nlens = [0.1, -0.01]\nrate = 60\n"
                "quality = 100\nnoise = { pixel = 2.5 }\n");
  EXPECT_EQ(other.camera.height, 1920);
  EXPECT_EQ(other.camera.focal, 900);
  EXPECT_EQ(other.camera.k2, -0.01);
  EXPECT_EQ(other.camera.quality, 100);
  EXPECT_EQ(other.noise.pixel, 2.5);
  EXPECT_NEAR(sensor_of(camera + "size = [320, 240]\nfov = 90\n").camera.focal, 160, 1e-9);

  const auto has = [&](const std::string& line, const std::string& problem) {
    EXPECT_THAT(problems(camera + line + "\n"), ElementsAre(HasSubstr(problem))) << line;
  };
  has("size = [15, 240]", "size must be two whole numbers from 16 to 1920");
  has("size = [1921, 240]", "size must be two whole numbers from 16 to 1920");
  has("size = [320.5, 240]", "size must be two whole numbers from 16 to 1920");
  has("fov = 60\nfocal = 500", "a camera has fov, in degrees, or focal, in pixels");
  has("fov = 139", "no lens is like this");
  has("lens = [-0.9, 0]", "no lens is like this");
  has("lens = [1]", "k1, k2");
  has("rate = 0", "rate");
  has("quality = 0", "quality");
  has("quality = 101", "quality");
  has("period = \"2s\"", "only satellite receivers have a period");
  EXPECT_THAT(problems(robot + "name = \"l\"\nkind = \"scanner\"\nrate = 5\nfov = 60\n"),
              ElementsAre("w.toml:7:1: only cameras have rate"));
}

TEST(WorldFile, HasTheWallsOfAMapOfRos) {
  const WorldFile file = read("[[plan]]\nfile = \"maps/hall.yaml\"\nheight = 2000\n");
  ASSERT_THAT(file.problems, IsEmpty());
  ASSERT_EQ(file.description.walls.size(), 1U) << "in the middle of the cells";
  const WallDescription& wall = file.description.walls.front();
  EXPECT_EQ(wall.height, 2000);
  EXPECT_EQ(wall.from.x, 50);
  EXPECT_EQ(wall.to.x, 50);
  EXPECT_EQ(std::abs(wall.to.y - wall.from.y), 200);
  EXPECT_THAT(problems("[[plan]]\nfile = \"maps/none.yaml\"\n"),
              ElementsAre("w.toml:2:8: maps/none.yaml: its image: maps/none.pgm: No such file or "
                          "directory"));
  EXPECT_THAT(problems("[[plan]]\nfile = \"maps/hall.yaml\"\noffset = [1, 2]\n"),
              ElementsAre("w.toml:3:10: a map of ROS has no offset: its .yaml file states its "
                          "resolution and origin"));
}

TEST(WorldFile, HasTheMarkersOfAMap) {
  const auto read_with = [](const std::string& map) {
    return read_world(
        {"w.toml", "markers = \"map.toml\"\n"},
        [&](const std::string& name) -> tims::Result<std::string> {
          EXPECT_EQ(name, "map.toml");
          return map;
        },
        decode);
  };
  const WorldFile file = read_with("[[marker]]\nid = 7\nat = [1000, 200, 180]\n");
  ASSERT_THAT(file.problems, IsEmpty());
  ASSERT_EQ(file.description.markers.size(), 1U);
  EXPECT_EQ(file.description.markers[0].id, 7);
  EXPECT_EQ(file.description.markers[0].at.y, 200);
  const WorldFile wrong = read_with("[[marker]]\nid = -1\nat = [1000, 200, 180]\n");
  ASSERT_FALSE(wrong.problems.empty());
  EXPECT_THAT(wrong.problems[0].to_string(), HasSubstr("map.toml:"));
  EXPECT_THAT(problems("markers = \"none.toml\"\n"),
              ElementsAre(HasSubstr("none.toml: No such file")));
}

TEST(CameraLens, BendsEveryDirectionIntoOnePlace) {
  CameraDescription camera{.width = 600, .height = 800, .focal = 500};  // its corners: tangent 1
  EXPECT_TRUE(is_possible(camera));
  // r (1 + k1 r^2) grows up to r = 1 / sqrt(-3 k1), where it is 2/3 of that.
  camera.k1 = -0.148;
  EXPECT_TRUE(is_possible(camera));
  camera.k1 = -0.149;
  EXPECT_FALSE(is_possible(camera));
  camera = {.width = 600, .height = 800, .focal = 500 / kSteepest + 0.1};
  EXPECT_TRUE(is_possible(camera));
  camera.focal -= 0.2;
  EXPECT_FALSE(is_possible(camera)) << "too wide";
}

TEST(WorldFile, HasNoMoreThanThereIsRoomFor) {
  std::string text;
  for (std::size_t i = 0; i < 3 * kRobotsMax; ++i)
    text += "[[robot]]\nname = \"r" + std::to_string(i) + "\"\nat = [0, 0, 0]\n";
  EXPECT_THAT(problems(text), ElementsAre("w.toml:49:1: more than 16 robots"));
}

TEST(WorldFile, WithoutGroundItIsAsLargeAsItsWalls) {
  const Area ground = read("[[wall]]\nfrom = [0, 0]\nto = [9000, -500]\n").description.ground;
  EXPECT_EQ(ground.from.y, -1500);
  EXPECT_EQ(ground.to.x, 10000);
  EXPECT_EQ(read("").description.ground.to.x, WorldDescription{}.ground.to.x);
}

// Whatever somebody's editor or disk makes of it.
TEST(WorldFile, SurvivesMutations) {
  std::ifstream file(WORLDS "/floor.toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_FALSE(text.empty());
  Random random(11);
  std::size_t good = 0;
  for (int run = 0; run < 3000; ++run) {
    std::string mutated = text;
    for (std::uint32_t i = 0; i <= random.below(4); ++i) {
      const std::size_t at = random.below(static_cast<std::uint32_t>(mutated.size()));
      const std::size_t from = random.below(static_cast<std::uint32_t>(text.size()));
      switch (random.below(4)) {
        case 0:
          mutated[at] = static_cast<char>(random.below(256));
          break;
        case 1:
          mutated.erase(at, random.below(40));
          break;
        case 2:
          mutated.insert(at, text.substr(from, random.below(60)));
          break;
        default:
          mutated[at] = static_cast<char>('0' + random.below(10));
      }
      if (mutated.empty()) mutated = "x";
    }
    WorldFile read_file = read_world({"w", mutated}, square, decode);
    for (const auto& problem : read_file.problems) EXPECT_EQ(problem.at.file, "w");
    if (!read_file.problems.empty()) continue;
    read_file.description.people.count = 0;
    read_file.description.people.walks.clear();
    if (auto world = World::make(read_file.description, kBegin)) world->advance(kBegin + kStep);
    ++good;
  }
  EXPECT_LT(good, 2900U);
}

struct FloorLimits {
  explicit FloorLimits(const std::vector<WallDescription>& walls) {
    for (const WallDescription& wall : walls) {
      for (const MapPoint& end : {wall.from, wall.to}) {
        from = {std::min(from.x, end.x), std::min(from.y, end.y)};
        to = {std::max(to.x, end.x), std::max(to.y, end.y)};
      }
    }
  }
  [[nodiscard]] bool contain(const MapPoint& at) const {
    return at.x > from.x && at.x < to.x && at.y > from.y && at.y < to.y;
  }
  MapPoint from{1e9, 1e9};
  MapPoint to{-1e9, -1e9};
};

WorldFile deployed(const std::string& name) {
  const auto text_of = [](const std::string& path) -> tims::Result<std::string> {
    std::ifstream file(path, std::ios::binary);
    if (!file) return tims::Error(tims::Errc::kSystem, path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string folder = WORLDS "/";
  return read_world(
      {name, text_of(folder + name).value()},
      [&](const std::string& plan) { return text_of(folder + plan); }, decode);
}

// People and robots have room in the worlds that come with it, and a scanner sees something.
TEST(WorldFile, ThoseThatAreDeployedAreWorlds) {
  for (const std::string name : {"floor.toml", "dora.toml"}) {
    const WorldFile file = deployed(name);
    ASSERT_THAT(file.problems, IsEmpty()) << file.problems.front().to_string();
    EXPECT_THAT(file.remarks, IsEmpty());
    World world = made(file.description);
    world.advance(kBegin + seconds(60));
    const Truth truth = world.make_truth();
    const PeopleDescription& people = file.description.people;
    EXPECT_EQ(truth.people.size(), people.count + people.walks.size());
    // Nobody is outside of the walls, where robots never come.
    const FloorLimits limits(file.description.walls);
    for (const PersonTruth& person : truth.people) EXPECT_TRUE(limits.contain(person.at)) << name;
    const auto laser = world.find_sensor(file.description.robots[0].name, "laser");
    ASSERT_TRUE(laser);
    int hits = 0;
    for (int i = 0; i < 181; ++i)
      hits += world.measure(*laser, {.azimuth = radians(i - 90.0)}, world.now()).is_valid ? 1 : 0;
    EXPECT_GT(hits, 60) << name;
  }
}

}  // namespace world_file_test
}  // namespace rack::world
