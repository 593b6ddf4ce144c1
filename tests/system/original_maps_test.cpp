// The windows for Mcl, FeatureMap, GridMap, Position, the common map and Scan3d of the original's
// GUI with our components: what they send, receive and paint.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "rack/proxies/chassis.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan3d.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/original_window.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace original_maps_test {

using rack::i16;
using rack::i32;

constexpr std::uint32_t kChassis = 0x00110000;
constexpr std::uint32_t kPosition = 0x00130000;
constexpr std::uint32_t kObjRecog = 0x001B0000;
constexpr std::uint32_t kScan3d = 0x00210000;
constexpr std::uint32_t kFeatureMap = 0x00230000;
constexpr std::uint32_t kGridMap = 0x00240000;
constexpr std::uint32_t kMcl = 0x00260000;

class OriginalMapsTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    ::setenv("RACK_FILES", folder_.path().c_str(), 1);
    gui_.emplace(router_.tcp());
  }
  Window open_window(std::uint32_t component) { return gui_->open_window(component); }
  // Presses On until the components that it needs are available, as users do.
  static void press_on_until_ok(Window& window) {
    ASSERT_TRUE(eventually([&] { return window.answer_to(type::kOn) == type::kOk; }, "it is on"));
  }

  std::optional<OriginalGui> gui_;
  TemporaryFolder folder_;
};

// x, y, z, phi, psi, rho and their deviations.
struct Place {
  std::array<i32, 3> xyz{};
  float rho = 0;
};
Place place_of(Fields& fields) {
  Place place;
  for (i32& value : place.xyz) value = fields.next<i32>();
  fields.skip<float>(2);
  place.rho = fields.next<float>();
  return place;
}

// --- Position, and the common map

// The message of a click on the map: without time and deviations.
Body position_update(i32 x, i32 y, float rho) {
  return Body().add(i32{0}).add(x, y, i32{0}, 0.0F, 0.0F, rho).text("", 24);
}

TEST_F(OriginalMapsTest, PositionIsShownAndSetByAClick) {
  start("ChassisSim");
  start("OdometryChassis");
  start("Position");
  Window window = open_window(kPosition);
  EXPECT_FALSE(window.poll()) << "it is off";
  EXPECT_EQ(window.answer_to(21, position_update(1, 2, 0)), type::kError);
  press_on_until_ok(window);
  const auto shows = [&](i32 x, i32 y, float rho) {
    return eventually(
        [&] {
          const auto message = window.poll();
          if (!message) return false;
          EXPECT_EQ(message->body.size(), 52U);
          Fields fields(*message);
          fields.next<i32>();
          const Place at = place_of(fields);
          const Place deviation = place_of(fields);
          EXPECT_GE(deviation.xyz[0], 0);
          return std::abs(at.xyz[0] - x) < 3 && std::abs(at.xyz[1] - y) < 3 &&
                 std::abs(at.rho - rho) < 0.01F;
        },
        "the place that was set");
  };
  EXPECT_TRUE(shows(0, 0, 0));
  EXPECT_EQ(window.answer_to(21, position_update(7000, -9000, 1.5F)), type::kOk);
  EXPECT_TRUE(shows(7000, -9000, 1.5F));
}

// The common map paints the hull; it requests it when it is opened, whichever components are on.
TEST_F(OriginalMapsTest, TheHullOfTheChassisIsPainted) {
  start("ChassisSim");
  const auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)").get_parameter();
  ASSERT_TRUE(chassis) << chassis.error().message();
  Window map = open_window(kChassis);
  const auto answer = map.ask(rack::ChassisType::kGetParameter);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->header.type, rack::ChassisType::kParameter);
  EXPECT_EQ(answer->body.size(), 88U);
  Fields fields(*answer);
  fields.skip<i32>(12);
  for (const auto side : {chassis->boundaryFront, chassis->boundaryBack, chassis->boundaryLeft,
                          chassis->boundaryRight}) {
    EXPECT_GT(side, 0);
    EXPECT_EQ(fields.next<i32>(), side);
  }
}

// --- Mcl

struct Cloud {
  std::vector<std::array<i32, 2>> samples;
  std::vector<std::array<i32, 2>> measurements;
};

// Points of the types that the window knows are squares; pairs of points are lines.
Cloud paint_cloud(const OwnedMessage& message) {
  Fields fields(message);
  fields.next<i32>();
  place_of(fields);
  const auto count = static_cast<std::size_t>(fields.next<i32>());
  EXPECT_LE(count, 1000U);
  EXPECT_EQ(message.body.size(), 32 + 20 * count);
  Cloud cloud;
  std::size_t ends = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array at{fields.next<i32>(), fields.next<i32>()};
    fields.next<i32>();
    const i32 kind = fields.next<i32>();
    fields.next<i32>();
    if (kind == rack::mcl_point::kSample) cloud.samples.push_back(at);
    if (kind == rack::mcl_point::kMeasurement) cloud.measurements.push_back(at);
    if (kind == rack::mcl_point::kLine) ++ends;
  }
  EXPECT_EQ(ends % 2, 0U);
  return cloud;
}

TEST_F(OriginalMapsTest, MclShowsItsSamplesAndTheEndsOfBeams) {
  start("ChassisSim");
  start("OdometryChassis", {"--initPosX=3000", "--initPosY=2500"});
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("MonteCarloLocalisation", {"--startX=3000", "--startY=2500", "--period=200"});
  Window window = open_window(kMcl);
  // File names as Java writes them: without padding.
  const auto name = [](std::string_view file) {
    return Body().add(static_cast<i32>(file.size())).text(file);
  };
  EXPECT_EQ(window.answer_to(21, name("/nowhere/floor.dxf")), type::kError);
  EXPECT_EQ(window.answer_to(21, name(FLOOR_PLAN)), type::kError) << "not in the folder";
  std::filesystem::copy(FLOOR_PLAN, folder_.path() / "floor.dxf");
  EXPECT_EQ(window.answer_to(21, name("floor.dxf")), type::kOk);
  press_on_until_ok(window);
  Cloud cloud;
  ASSERT_TRUE(eventually(
      [&] {
        const auto message = window.poll();
        if (message) cloud = paint_cloud(*message);
        return cloud.measurements.size() > 30;
      },
      "samples and measurements"));
  EXPECT_GE(cloud.samples.size(), 100U);
  double x = 0;
  for (const auto& sample : cloud.samples) x += sample[0];
  EXPECT_NEAR(x / static_cast<double>(cloud.samples.size()), 3000, 300);
}

// --- FeatureMap and GridMap

struct Line {
  std::array<double, 4> ends{};  // x, y, x2, y2
  i32 layer = 0;
};

std::vector<Line> lines_of(const OwnedMessage& message) {
  Fields fields(message);
  fields.next<i32>();
  place_of(fields);
  const auto count = static_cast<std::size_t>(fields.next<i32>());
  EXPECT_LE(count, 200U) << "the window has room for 200";
  EXPECT_EQ(message.body.size(), 32 + 72 * count);
  std::vector<Line> lines(count);
  for (Line& line : lines) {
    for (double& end : line.ends) end = fields.next<double>();
    fields.skip<double>(4);
    line.layer = fields.next<i32>();
    EXPECT_GE(line.layer, 0) << "the window has no colour for it";
    EXPECT_EQ(fields.next<i32>(), rack::FeatureMapDataPoint::kLine);
  }
  return lines;
}

// The message of clicks: the ends and, for a new line, length, layer and type. Other fields are 0
// or have old values.
Body feature(const std::array<double, 4>& ends, i32 layer, i32 number) {
  const auto& [x, y, x2, y2] = ends;
  return Body()
      .add(i32{0})
      .add(x, y, x2, y2, std::hypot(x2 - x, y2 - y), 0.0, 0.0, 0.0)
      .add(layer, i32{10}, number);
}

TEST_F(OriginalMapsTest, LinesAreAddedDisplacedDeletedAndSavedByClicks) {
  start("FeatureMap", {"--mapFile", FLOOR_PLAN, "--period=50"});
  Window window = open_window(kFeatureMap);
  EXPECT_FALSE(window.poll());
  window.press_on();
  const auto lines = [&]() -> std::vector<Line> {
    const auto message = window.poll();
    return message ? lines_of(*message) : std::vector<Line>();
  };
  const auto has = [&](std::size_t count) {
    return eventually([&] { return lines().size() == count; }, "so many lines");
  };
  const std::size_t count = lines().size();
  ASSERT_GT(count, 10U);
  using Type = rack::FeatureMapType;
  EXPECT_EQ(window.answer_to(Type::kAddLine, feature({1, 2, 301, 402}, 2, 0)), type::kOk);
  ASSERT_TRUE(has(count + 1));
  EXPECT_EQ(lines().back().layer, 2);
  // Selected by a click, then moved, and deleted. Without a selection the number is invalid.
  const auto marked = static_cast<i32>(count);
  EXPECT_EQ(window.answer_to(Type::kDisplaceLine, feature({9, 2, 9, 502}, 0, marked)), type::kOk);
  EXPECT_TRUE(eventually([&] { return lines().back().ends[3] == 502; }, "the line elsewhere"));
  EXPECT_EQ(window.answer_to(Type::kDeleteLine, feature({}, 0, marked + 2)), type::kError);
  EXPECT_EQ(window.answer_to(Type::kDeleteLine, feature({}, 0, marked)), type::kOk);
  ASSERT_TRUE(has(count));
  const std::string file = "mapFile";
  const Body name = Body().add(static_cast<i32>(file.size())).text(file);
  EXPECT_EQ(window.answer_to(Type::kSaveMap, name), type::kOk);
  EXPECT_EQ(window.answer_to(Type::kLoadMap, name), type::kOk);
  EXPECT_TRUE(has(count));
}

// A grey picture with north up; darker means more occupied.
struct Picture {
  i32 width = 0;
  i32 height = 0;
  i32 north = 0;  // x of the centre of the lowest row, mm
  i32 west = 0;   // y of the centre of the first column, mm
  i32 scale = 1;
  std::vector<int> shade{};

  [[nodiscard]] int at(double x, double y) const {
    const auto row = height - 1 - std::lround((x - north) / scale);
    const auto column = std::lround((y - west) / scale);
    if (row < 0 || row >= height || column < 0 || column >= width) return -1;
    return shade[static_cast<std::size_t>(row * width + column)];
  }
};

// The window exchanges the numbers of rows and columns, and rotates the map to the left.
Picture paint_cells(const OwnedMessage& message) {
  Fields fields(message);
  fields.next<i32>();
  Picture picture{.north = fields.next<i32>(), .west = fields.next<i32>()};
  picture.scale = fields.next<i32>();
  picture.height = fields.next<i32>();
  picture.width = fields.next<i32>();
  const auto cells = fields.rest();
  const auto size =
      static_cast<std::size_t>(picture.height) * static_cast<std::size_t>(picture.width);
  EXPECT_EQ(cells.size(), size);
  EXPECT_LE(size, 250'000U);
  picture.shade.resize(size);
  for (i32 column = 0; column < picture.width; ++column)
    for (i32 i = 0; i < picture.height; ++i)
      picture.shade[static_cast<std::size_t>(picture.width * (picture.height - i - 1) + column)] =
          255 - std::to_integer<int>(cells[static_cast<std::size_t>(picture.height * column + i)]);
  return picture;
}

TEST_F(OriginalMapsTest, WallsAreWhereBothMapsPaintThem) {
  start("FeatureMap", {"--mapFile", FLOOR_PLAN, "--period=50"});
  start("GridMap", {"--mapFile", FLOOR_PLAN, "--period=50"});
  Window lines = open_window(kFeatureMap);
  Window cells = open_window(kGridMap);
  EXPECT_FALSE(cells.poll());
  lines.press_on();
  cells.press_on();
  const auto drawn = lines.poll();
  const auto painted = cells.poll();
  ASSERT_TRUE(drawn && painted);
  const Picture picture = paint_cells(*painted);
  for (const Line& line : lines_of(*drawn)) {
    const auto& [x, y, x2, y2] = line.ends;
    EXPECT_EQ(picture.at((x + x2) / 2, (y + y2) / 2), 0) << x << ' ' << y << ' ' << x2 << ' ' << y2;
  }
  EXPECT_EQ(picture.at(3000, 2500), 255) << "the room in the middle is free";
}

// --- ObjRecog

// The window requests the next data, and paints boxes relative to the robot's position at that
// time.
TEST_F(OriginalMapsTest, ObjectsAreBoxesBeforeTheRobot) {
  std::ifstream plan(FLOOR_PLAN);
  std::string text((std::istreambuf_iterator<char>(plan)), {});
  const auto end = text.rfind("  0\nENDSEC");
  ASSERT_NE(end, std::string::npos);
  text.insert(end, "  0\nLINE\n  8\n0\n 10\n2.3\n 20\n3.8\n 11\n2.7\n 21\n3.8\n");
  const std::string furnished = folder_.path() / "furnished.dxf";
  std::ofstream(furnished) << text;
  start("ChassisSim");
  start("OdometryChassis", {"--initPosX=3000", "--initPosY=2500"});
  start("Scan2dSim", {"--mapFile", furnished});
  start("Position");
  ASSERT_TRUE(turned_on("Position(0/0)"));
  Window position = open_window(kPosition);
  ASSERT_EQ(position.answer_to(21, position_update(3000, 2500, 0)), type::kOk);
  start("ObjRecogScan2d",
        {"--scan2dInst=0", "--positionInst=0", "--mapFile", FLOOR_PLAN, "--maxRange=9999"});
  Window window = open_window(kObjRecog);
  EXPECT_FALSE(window.wait_for_next());
  press_on_until_ok(window);
  const auto look = [&]() -> std::string {
    const auto message = window.wait_for_next();
    if (!message) return "no data";
    Fields fields(*message);
    fields.next<i32>();
    EXPECT_NEAR(place_of(fields).xyz[0], 3000, 5);
    place_of(fields);
    const auto count = static_cast<std::size_t>(fields.next<i32>());
    EXPECT_LE(count, 100U) << "the window can select among 100";
    EXPECT_EQ(message->body.size(), 56 + 136 * count);
    if (count == 0) return "no object";
    EXPECT_GE(fields.next<i32>(), 0) << "its colour is id % 6";
    fields.next<i32>();
    const Place middle = place_of(fields);
    for (int i = 0; i < 3; ++i) place_of(fields);
    const std::array size{fields.next<i32>(), fields.next<i32>()};
    EXPECT_NEAR(middle.xyz[0], 800, 150);
    EXPECT_NEAR(middle.xyz[1], 0, 150);
    EXPECT_NEAR(std::max(size[0], size[1]), 600, 250) << "a possible person has room for a step";
    return "";
  };
  EXPECT_TRUE(eventually(look));
  // An estimate by a click is refused by a component that recognises objects itself.
  const Body estimate =
      Body().text("", 52).add(i32{1}, i32{0}, i32{0}, i32{800}, i32{0}).text("", 120);
  EXPECT_EQ(window.answer_to(rack::ObjRecogType::kSetEstimate, estimate), type::kError);
}

// --- Scan3d

// The window paints as many rows as the message states; this kind of scan is painted in squares.
TEST_F(OriginalMapsTest, Scan3dShowsItsRangeImageAndStoresPoints) {
  const std::string line = folder_.path() / "axis";
  auto axis = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/rack-emulate", "servo", "pty:" + line + "?can=125000"});
  ASSERT_TRUE(axis) << axis.error().message();
  ASSERT_TRUE(axis->wait_for_line("for driver"));
  start("ServoDrive", {"--gearRatio=10", "--velMax=90", "--accMax=400",
                       "--device=serial:" + line + "?can=125000"});
  start("ChassisSim");
  start("OdometryChassis");
  start("Position");
  start("tims-test-ladar");
  start("Scan3d", {"--ladarInst=0", "--servoDriveInst=0", "--angleMin=-20", "--angleMax=20",
                   "--axisVel=60", "--axisZ=-400", "--sectors=2", "--compress=1"});
  Window window = open_window(kScan3d);
  EXPECT_EQ(window.answer_to(rack::Scan3dType::kGetRangeImage), type::kError);
  press_on_until_ok(window);
  std::optional<OwnedMessage> image;
  ASSERT_TRUE(eventually(
      [&] {
        image = window.ask(rack::Scan3dType::kGetRangeImage);
        return image && image->header.type == rack::Scan3dType::kRangeImage;
      },
      "a complete scan"));
  Fields fields(*image);
  fields.next<i32>();
  const i32 mode = fields.next<i32>();
  EXPECT_EQ(mode & 0xFF, rack::scan_mode::kPitch);
  EXPECT_NE(mode & 0x200, 0) << "every second row would be shifted by half a pixel";
  fields.next<i32>();
  const auto rows = static_cast<std::size_t>(fields.next<i16>());
  const auto columns = static_cast<std::size_t>(fields.next<i16>());
  EXPECT_GT(rows, 20U);
  EXPECT_EQ(columns, 181U);
  ASSERT_EQ(image->body.size(), 16 + 4 * rows * columns);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < rows * columns; ++i) {
    if (fields.next<i16>() > 0) ++seen;
    fields.next<i16>();
  }
  EXPECT_GT(seen, rows * columns / 2);
  // To store points the window requests the next data and decompresses them: stages 3 (Huffman),
  // 2, 1.
  const auto next = window.wait_for_next();
  ASSERT_TRUE(next);
  Fields scan(*next);
  scan.skip<i32>(15);
  const i32 points = scan.next<i32>();
  const auto packed = static_cast<std::size_t>(scan.next<i32>());
  EXPECT_GT(points, 0);
  EXPECT_EQ(next->body.size(), 68 + packed);
  EXPECT_EQ(text_of(scan.rest().first(2)), "MC");
}

}  // namespace original_maps_test
}  // namespace tims::test
