// A ladar is tilted by an axis (a real driver and an emulated drive) while the robot drives at 2
// m/s: Scan3d sends sectors and complete scans with flat walls.
#include <fstream>
#include <optional>

#include <gmock/gmock.h>

#include "components/scan3d/hall_fixture.h"
#include "rack/proxies/scan3d_compression.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace scan3d_test {

using namespace std::chrono_literals;
using rack::Scan3dData;

constexpr double kFlat = 20;  // mm, p95

class Scan3dTest : public RobotTest {
 protected:
  void start_robot(const std::vector<std::string>& more = {}) {
    const std::string line = folder_.path() / "axis";
    axis_.emplace(*ChildProcess::start(
        {std::string(TIMS_PROGRAMS) + "/rack-emulate", "servo", "pty:" + line + "?can=125000"}));
    ASSERT_TRUE(axis_->wait_for_line("for driver"));
    start("ServoDrive", servo_arguments());
    start("ChassisSim", {"--vxMax=2000", "--periodTime=50", "--moveDeadline=0"});
    start("OdometryChassis");
    start("Position");
    start("tims-test-ladar");
    std::vector<std::string> arguments = {"--ladarInst=0",
                                          "--servoDriveInst=0",
                                          "--positionInst=0",
                                          "--angleMin=-35",
                                          "--angleMax=35",
                                          "--axisVel=60",
                                          "--axisX=300",
                                          "--axisZ=-400",
                                          "--ladarReversed=1",
                                          "--sectors=4",
                                          "--storePath=" + (folder_.path() / "scan").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    start("Scan3d", arguments);
    ASSERT_TRUE(turned_on("Scan3d(0/0)"));
    stream_.emplace(open(*session_, kWork + 1, {.slots = 32, .body_max = 1 << 20}));
    subscribe();
  }
  std::vector<std::string> servo_arguments() {
    return {"--gearRatio=10", "--velMax=90", "--accMax=400",
            "--device=serial:" + (folder_.path() / "axis").string() + "?can=125000"};
  }

  // Subscribes to its data; after an error it has no listeners any more.
  void subscribe() {
    stream_->clean();
    ASSERT_TRUE(eventually([&]() -> std::string {
      const auto granted = scanner().get_cont_data(0, stream_->address());
      return granted ? "" : granted.error().message();
    }));
  }
  // The next scan of so many sectors; nothing after a timeout.
  std::optional<Scan3dData> next(rack::i32 sectors) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      const auto message = stream_->peek_for(1s);
      Scan3dData scan;
      if (!message || !scanner().decode_stream(*message, scan)) continue;
      EXPECT_TRUE(compression_.decompress(scan));
      if (scan.sectorNum == sectors) return scan;
    }
    return {};
  }
  // With a long timeout, because it writes a file before it answers.
  rack::Scan3dProxy scanner() {
    return {*work_, *Address::parse("Scan3d(0/0)"), {.data = kPatience}};
  }

  TemporaryFolder folder_;
  std::optional<ChildProcess> axis_;
  std::optional<Mailbox> stream_;
  rack::Scan3dCompression compression_;
};

TEST_F(Scan3dTest, WallsAreFlatWhileItDrives) {
  start_robot();
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  ASSERT_TRUE(chassis.set_active_pilot(Address(kWork)).ok());
  const auto walls = rack::scan3d::hall(200'000);
  int driven = 0;
  int flat_walls = 0;
  rack::i32 last_x = 0;
  for (int tries = 0; tries < 20 && driven < 2; ++tries) {
    ASSERT_TRUE(chassis.move(2000, 0, 0.01F).ok());
    const auto scan = next(1);
    ASSERT_TRUE(scan);
    const double distance = scan->refPos.x - last_x;
    last_x = scan->refPos.x;
    if (tries == 0 || distance < 1500) continue;  // it started to drive during this scan
    ++driven;
    EXPECT_GT(scan->scanNum, 40);
    for (std::size_t wall = 0; wall < walls.size(); ++wall) {
      const auto flat = rack::scan3d::flatness(*scan, walls, wall);
      if (flat.points == 0) continue;
      ++flat_walls;
      EXPECT_LE(flat.p95, kFlat) << "wall " << wall;
    }
  }
  EXPECT_EQ(driven, 2);
  EXPECT_GE(flat_walls, 4);
}

TEST_F(Scan3dTest, SectorsPictureFileAndCompression) {
  start_robot({"--compress=1", "--positionInst=-1"});
  const auto packed = scanner().get_next_data(5s);
  ASSERT_TRUE(packed) << packed.error().message();
  EXPECT_GT(packed->compressed, 0);
  EXPECT_LT(packed->compressed * 2, packed->pointNum * 20);
  const auto sector = next(4);
  ASSERT_TRUE(sector);
  EXPECT_EQ(sector->scanMode & 0xFF, rack::scan_mode::kPitch);
  const auto whole = next(1);
  ASSERT_TRUE(whole);
  EXPECT_GT(whole->scanNum, sector->scanNum);

  const auto image = scanner().get_range_image();
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->scanPointNum, 181);
  EXPECT_EQ(image->points.size(), static_cast<std::size_t>(image->scanNum) * 181);
  ASSERT_TRUE(scanner().store_data());
  std::ifstream file(folder_.path() / "scan_1.3d");
  const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  EXPECT_GT(lines, 181 * 40);
}

TEST_F(Scan3dTest, ContinuesWhenItsAxisHasRestarted) {
  start_robot();
  ASSERT_TRUE(next(1));
  kill("ServoDrive");
  ASSERT_TRUE(eventually([&] { return !scanner().get_next_data(1s).ok(); }, "that it noticed"));
  start("ServoDrive", servo_arguments());
  subscribe();
  EXPECT_TRUE(next(1));
}

TEST_F(Scan3dTest, RefusalsHaveReasons) {
  start("Scan3d", {"--ladarInst=0", "--servoDriveInst=0", "--angleMin=30", "--angleMax=30"});
  auto scanner = proxy<rack::Scan3dProxy>("Scan3d(0/0)");
  const auto on = scanner.on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), testing::HasSubstr("angleMax is not larger"));
  const auto image = scanner.get_range_image();
  ASSERT_FALSE(image);
  EXPECT_THAT(image.error().message(), testing::HasSubstr("no whole scan yet"));
}

}  // namespace scan3d_test
}  // namespace tims::test
