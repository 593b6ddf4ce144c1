// The surveying robot of the samples: two scanners merged into one scan with moving points marked,
// and 3D scans of a scanner that a servo axis tilts, while the robot drives through its hall at 2
// m/s.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "components/scan3d/hall_fixture.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d_compression.h"
#include "tests/system/sample_robot_fixture.h"

namespace tims::test {
namespace surveyor_robot_test {

using namespace std::chrono_literals;
using rack::Scan3dData;

constexpr double kFlat = 20;  // mm, p95
constexpr int kFast = 1900;   // mm/s: the highest speed in the plan's profile, of 2 m/s

// The walls and the floor; too few points are measured at the distant ends of the hall.
std::vector<rack::scan3d::Plane> hall() {
  return {{{1, 0, 0}, 36000},
          {{-1, 0, 0}, 4000},
          {{0, 1, 0}, 8000},
          {{0, -1, 0}, 4000},
          {{0, 0, 1}, 0}};
}

// The depth of the measured floor below the real one, as the median of near points. A wrong or late
// angle of the axis keeps planes flat but displaces them.
double depth_of_the_floor(const Scan3dData& scan) {
  std::vector<double> depths;
  for (const rack::ScanPoint& point : scan.points) {
    if ((point.type & rack::scan_point::kInvalid) != 0) continue;
    const bool is_near = std::hypot(point.x.raw(), point.y.raw()) < 6000;
    if (is_near && std::abs(point.z.raw()) < 500) depths.push_back(point.z.raw());
  }
  if (depths.empty()) return 500;
  std::ranges::nth_element(depths, depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2));
  return depths[depths.size() / 2];
}

class SurveyorRobotTest : public SampleRobotTest {
 protected:
  void SetUp() override {
    SampleRobotTest::SetUp();
    start_robot(TIMS_ROBOTS "/surveyor.toml", 17);
  }

  int speed() {
    const auto now = truth();
    const auto* const robot = now.find(rack::world_thing::kRobot, "surveyor");
    return robot == nullptr ? 0 : robot->vx.raw();
  }
  static int dynamic_points(const rack::Scan2dData& scan) {
    return static_cast<int>(std::ranges::count_if(scan.points, [](const rack::ScanPoint& point) {
      return (point.type & rack::scan_point::kClassMask) == 3;
    }));
  }
};

// Points on walking people are dynamic; the crates are objects that do not move.
TEST_F(SurveyorRobotTest, ScansAllAroundAndMarksMovingObjects) {
  ASSERT_TRUE(turned_on(of_system("ObjRecog")));
  ASSERT_TRUE(turned_on(of_system("Scan2d", 3)));
  auto scanner = of_robot<rack::Scan2dProxy>("Scan2d", 3);
  auto recogniser = of_robot<rack::ObjRecogProxy>("ObjRecog");
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto scan = scanner.get_data();
    if (!scan) return scan.error().message();
    const auto segment = [&](int wanted) {
      return std::ranges::count(scan->points, wanted, &rack::ScanPoint::segment);
    };
    return segment(1) > 300 && segment(2) > 300 ? "" : "not both scanners";
  }));
  int marked = 0;
  int astray = 0;
  EXPECT_TRUE(eventually(
      [&] {
        const auto scan = scanner.get_next_data(kPatience);
        const auto now = truth();
        const auto* const robot = now.find(rack::world_thing::kRobot, "surveyor");
        if (!scan || robot == nullptr) return false;
        for (const rack::ScanPoint& point : scan->points) {
          if ((point.type & rack::scan_point::kClassMask) != 3) continue;
          const bool is_somebody = std::ranges::any_of(now.things, [&](const auto& thing) {
            return thing.kind == rack::world_thing::kPerson &&
                   std::hypot(thing.pos.x.raw() - robot->pos.x.raw() - point.x.raw(),
                              thing.pos.y.raw() - robot->pos.y.raw() - point.y.raw()) < 1000;
          });
          ++(is_somebody ? marked : astray);
        }
        return marked > 300;
      },
      "dynamic points on walking people", kDrive));
  EXPECT_LT(astray, marked / 20);
  EXPECT_TRUE(eventually(
      [&] {
        const auto seen = recogniser.get_data();
        return seen && std::ranges::any_of(seen->objects, [](const rack::ObjRecogObject& object) {
                 return std::hypot(object.pos.x.raw() - 12000, object.pos.y.raw() + 3300) < 1500 &&
                        std::hypot(object.vel.x.raw(), object.vel.y.raw()) < 1;
               });
      },
      "the crate", kDrive));
}

TEST_F(SurveyorRobotTest, WallsOfIts3dScansAreFlatAtTwoMetresPerSecond) {
  ASSERT_TRUE(world().let_people_move(false).ok());
  ASSERT_TRUE(turned_on(of_system("Scan3d")));
  auto stream = open(*session_, kWork + 1, {.slots = 32, .body_max = 1 << 20});
  auto scanner = of_robot<rack::Scan3dProxy>("Scan3d");
  ASSERT_TRUE(scanner.get_cont_data(0, stream.address()).ok());
  ChildProcess going = begin({"nav", "goto", "26", "0", "--timeout", "20s", "--for", "80s"});
  rack::Scan3dCompression compression;
  const auto walls = hall();
  int before = 0;
  int sweeps = 0;
  int seen_walls = 0;
  int flat_walls = 0;
  std::vector<double> beside;
  auto ended = going.wait(1ms);
  for (; !ended; ended = going.wait(1ms)) {
    const auto message = stream.peek_for(100ms);
    Scan3dData scan;
    if (!message || !scanner.decode_stream(*message, scan)) continue;
    EXPECT_TRUE(compression.decompress(scan));
    if (scan.sectorNum != 1) continue;
    const int now = speed();
    const bool is_fast = std::min(now, std::exchange(before, now)) > kFast;
    if (!is_fast) continue;
    ++sweeps;
    EXPECT_LT(std::abs(depth_of_the_floor(scan)), 40);
    for (std::size_t wall = 0; wall < walls.size(); ++wall) {
      const auto flat = rack::scan3d::flatness(scan, walls, wall);
      if (flat.points == 0) continue;
      ++seen_walls;
      if (flat.p95 <= kFlat) ++flat_walls;
      beside.push_back(flat.p95);
    }
  }
  EXPECT_EQ(ended->code, 0) << going.output() << up_->output();
  EXPECT_GE(sweeps, 2);
  EXPECT_GE(seen_walls, 3 * sweeps);
  // On a busy machine a time stamp of odometry or scanner is sometimes late by a few ms.
  EXPECT_GE(4 * flat_walls, 3 * seen_walls) << testing::PrintToString(beside);
  std::ranges::sort(beside);
  if (beside.empty()) return;
  RecordProperty("median_of_p95_mm", std::to_string(beside[beside.size() / 2]));
  RecordProperty("worst_p95_mm", std::to_string(beside.back()));
  const auto now = truth();
  const auto* const robot = now.find(rack::world_thing::kRobot, "surveyor");
  ASSERT_NE(robot, nullptr);
  EXPECT_EQ(robot->contacts(), 0U);
  EXPECT_LT(std::hypot(robot->pos.x.raw() - 26000, robot->pos.y.raw()), 300);
}

}  // namespace surveyor_robot_test
}  // namespace tims::test
