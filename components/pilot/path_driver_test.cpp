// How a pilot processes a list of destinations when the path accepts or refuses them.
#include "components/pilot/path_driver.h"

#include <array>

#include <gtest/gtest.h>

#include "components/path/polar_spline.h"
#include "components/pilot/car_fixture.h"

namespace rack::pilot {
namespace path_driver_test {

constexpr int kPeriod = 50;  // ms

DestinationPoint at(i32 x) { return {.pos = {.x = x}, .speed = 0}; }

// A robot without eyes that is always where its path begins, or at its end.
class Robot {
 public:
  Robot() {
    EXPECT_TRUE(driver.begin({.chassis = indoor_chassis(),
                              .maxSpeed = 700,
                              .looks = 0,
                              .positionPeriod = kPeriod,
                              .chassisPeriod = kPeriod}));
  }

  // Steps until there is a request, for at most `ms`; `waited` is the time until then.
  PathDriver::Request go(int ms) {
    for (waited = 0; waited < ms; waited += kPeriod) {
      look(0);
      if (auto request = driver.take_request(); request.next) return request;
    }
    return {};
  }
  // The path component sends a path of that length, and it is driven to its end.
  void goes(i32 length) {
    begins(length);
    here_ += length;
  }
  void begins(i32 length) {
    PathData& path = driver.inputs().path;
    path.splines.clear();
    path.splines.push_back(path::line({.x = static_cast<double>(here_)}, length));
    PolarSpline& spline = path.splines.back();
    spline.vMax = spline.vStart = 500;
    spline.accMax = spline.decMax = 700;
    spline.lbo = 1000;
    path.recordingTime = TimeStamp(static_cast<u32>(time_));
    look(PathCycle::kPath);
    EXPECT_EQ(driver.status().pilotState, pilot_state::kRunning);
  }
  // The path has refused, and reports it later.
  void wait(int ms) {
    for (int left = ms; left > 0; left -= kPeriod) look(0);
  }
  void has_no_path() {
    driver.inputs().path.splines.clear();
    driver.inputs().path.recordingTime = TimeStamp(static_cast<u32>(time_));
    look(PathCycle::kPath);
  }

  void is_at(i32 x) { here_ = x; }

  PathDriver driver;
  int waited = 0;

  void look(u32 came) {
    time_ += kPeriod;
    const TimeStamp now(static_cast<u32>(time_));
    driver.inputs().position.recordingTime = now;
    driver.inputs().position.pos.x = here_;
    driver.inputs().chassis.recordingTime = now;
    driver.step({.time = now, .came = came | PathCycle::kPosition | PathCycle::kChassis});
  }

  i32 here_ = 0;
  int time_ = 1000;
};

TEST(PathDriver, ADestinationThatIsRefusedStaysTheNext) {
  Robot robot;
  robot.driver.keep(std::array{at(2000), at(3000)});
  robot.goes(1000);
  auto request = robot.go(1000);
  ASSERT_TRUE(request.next);
  EXPECT_EQ(request.next->pos.x, 2000);
  for (int refusals = 0; refusals < 3; ++refusals) {
    robot.driver.plan(pilot_state::kPathError);  // at once
    request = robot.go(20'000);
    ASSERT_TRUE(request.next);
    EXPECT_EQ(request.next->pos.x, 2000);
    EXPECT_GE(robot.waited, 4000) << "it does not press";
    EXPECT_EQ(robot.driver.status().pilotState, pilot_state::kPlanning);
  }
  robot.has_no_path();  // after a while
  EXPECT_EQ(robot.driver.status().pilotState, pilot_state::kPathError);
  request = robot.go(20'000);
  ASSERT_TRUE(request.next);
  EXPECT_EQ(request.next->pos.x, 2000);

  robot.goes(1000);
  request = robot.go(1000);
  ASSERT_TRUE(request.next);
  EXPECT_EQ(request.next->pos.x, 3000) << "each once";
  robot.goes(1000);
  EXPECT_FALSE(robot.go(20'000).next) << "that was all";
}

TEST(PathDriver, ANewDestinationReplacesARefusedOne) {
  Robot robot;
  robot.driver.keep(std::array{at(2000)});
  robot.goes(1000);
  ASSERT_TRUE(robot.go(1000).next);
  robot.driver.plan(pilot_state::kPathError);
  robot.driver.keep({});
  EXPECT_FALSE(robot.go(20'000).next);
  robot.driver.keep(std::array{at(5000)});
  robot.goes(500);
  const auto request = robot.go(1000);
  ASSERT_TRUE(request.next);
  EXPECT_EQ(request.next->pos.x, 5000);
}

TEST(PathDriver, HoldsWhileNobodyMonitorsTheDrive) {
  Robot robot;
  robot.driver.plan(pilot_state::kPlanning);
  robot.begins(5000);
  robot.driver.watch({.timeout = 200});
  robot.wait(150);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kDrives);
  robot.wait(50);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kUnwatched);
  robot.driver.hold({.holdState = 0});
  robot.wait(kPeriod);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kUnwatched) << "HOLD is another matter";

  robot.driver.watch({.timeout = 200});
  robot.wait(kPeriod);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kDrives);
  robot.driver.watch({.timeout = 0});
  robot.wait(10'000);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kDrives) << "the watch has ended";

  robot.driver.watch({.timeout = 200});
  robot.wait(300);
  robot.driver.plan(pilot_state::kPlanning);
  robot.wait(kPeriod);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kDrives) << "another destination";
}

TEST(PathDriver, WaitsAsideWithoutHavingArrived) {
  Robot robot;
  robot.begins(1000);
  PathData& path = robot.driver.inputs().path;
  path.splines.push_back(path::line({.x = 1000}, 2000));
  ASSERT_TRUE(path::is_waiting(path.splines.back()));
  path.recordingTime = path.recordingTime + std::chrono::milliseconds(1);
  robot.look(PathCycle::kPath);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kMakesRoom);
  robot.is_at(1000);
  robot.wait(5000);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kWaitsAside);
  EXPECT_EQ(robot.driver.status().pilotState, pilot_state::kRunning);
  EXPECT_EQ(robot.driver.status().distanceToDest, 2000);
  EXPECT_EQ(robot.driver.status().speed, 0);
  robot.begins(500);
  EXPECT_EQ(robot.driver.why(), PathDriver::Why::kDrives);
}

}  // namespace path_driver_test
}  // namespace rack::pilot
