#include "components/pilot/lab_course.h"

#include <gtest/gtest.h>

#include "components/pilot/car_fixture.h"

namespace rack::pilot {
namespace lab_course_test {

using State = LabCourse::State;

class Course : public ::testing::Test {
 protected:
  void run(int periods, const Scan2dData& scan = {}) {
    for (int i = 0; i < periods && course.state() != State::kIdle; ++i) {
      const Drive drive = course.go(car.measured(), scan);
      for (int k = 0; k < 20; ++k)
        car.step({static_cast<double>(drive.speed), static_cast<double>(drive.omega)});
    }
  }
  static PilotDestData place(i32 x, i32 y, f32 rho) {
    PilotDestData data;
    data.pos.x = x;
    data.pos.y = y;
    data.pos.rho = rho;
    return data;
  }
  Car car{{.chassis = indoor_chassis(), .lag = 0.05, .position_noise = 2, .turns_at_rest = true},
          {},
          1};
  LabCourse course{{.speed_max = 1000, .omega_max = 10}, indoor_chassis()};
};

TEST_F(Course, GetsThere) {
  EXPECT_EQ(course.distance({}), -1);
  for (const auto& goal : {place(-3000, 2000, 1), place(1000, 1000, 3), place(1000, 1000, 0)}) {
    course.set_destination(goal);
    run(1000);
    EXPECT_EQ(course.state(), State::kIdle);
    EXPECT_NEAR(car.truth().x, goal.pos.x, 80);
    EXPECT_NEAR(car.truth().y, goal.pos.y, 80);
    EXPECT_NEAR(signed_angle(car.truth().rho - goal.pos.rho), 0, 0.1);
    EXPECT_EQ(course.distance(car.truth()), 0);
  }
}

TEST_F(Course, WaitsBeforeAnObstacle) {
  course.set_destination(place(5000, 0, 0));
  Scan2dData scan;
  scan.points.push_back({.x = 380, .y = 0});
  run(50, scan);
  EXPECT_EQ(course.state(), State::kDrive);
  EXPECT_LT(std::abs(car.truth().x), 1);
  run(1000);
  EXPECT_EQ(course.state(), State::kIdle);
}

// Each of the six parameters of the original limits something.
class LabSettings : public ::testing::Test {
 protected:
  // The command after it has turned to a destination that is so far ahead, and so far to the right.
  static Drive command(const LabCourseSettings& settings, i32 ahead, i32 right = 0,
                       const Scan2dData& scan = {}) {
    ChassisParamData chassis = indoor_chassis();
    chassis.vyMax = 400;
    LabCourse course(settings, chassis);
    PilotDestData goal;
    goal.pos.x = ahead;
    goal.pos.y = right;
    course.set_destination(goal);
    (void)course.go({}, scan);
    return course.go({}, scan);
  }
};

TEST_F(LabSettings, TheSpeedsHaveLimits) {
  EXPECT_EQ(command({}, 5000).speed, 300) << "speedMax of the original";
  EXPECT_EQ(command({.speed_max = 100}, 5000).speed, 100);
  EXPECT_EQ(command({.speed_max = 1'000'000}, 1'000'000).speed, indoor_chassis().vxMax);
  EXPECT_NEAR(command({.omega_max = radians(5)}, 0, 3000).omega, radians(5), 1e-6);
  EXPECT_NEAR(command({.omega_max = radians(5)}, 0, -3000).omega, -radians(5), 1e-6);
}

TEST_F(LabSettings, ItBecomesSlowerNearTheDestination) {
  EXPECT_EQ(command({.speed_max = 400, .slow_distance = 2000}, 2000).speed, 400);
  EXPECT_EQ(command({.speed_max = 400, .slow_distance = 2000}, 1000).speed, 200);
  EXPECT_EQ(command({.speed_max = 400, .slow_distance = 2000}, 60).speed, indoor_chassis().vxMin)
      << "it gets there";
}

TEST_F(LabSettings, ItTurnsFirstWhenTheDestinationIsAside) {
  EXPECT_EQ(command({.heading_error = radians(15)}, 3000, 1000).speed, 0) << "18 degrees";
  EXPECT_EQ(command({.heading_error = radians(20)}, 3000, 1000).speed, 300);
}

TEST_F(LabSettings, ItKeepsItsDistanceFromObstacles) {
  Scan2dData scan;
  const ChassisParamData chassis = indoor_chassis();
  const i32 hull = chassis.boundaryFront.raw() + chassis.safetyMargin.raw();
  scan.points.push_back({.x = hull + 800, .y = 0});
  EXPECT_EQ(command({.obstacle_distance = 800}, 5000, 0, scan).speed, 0);
  EXPECT_GT(command({.obstacle_distance = 799}, 5000, 0, scan).speed, 0);
}

TEST_F(LabSettings, ItDrivesSidewaysWhenItMay) {
  EXPECT_EQ(command({}, 3000, 600).side, 0);
  EXPECT_NEAR(command({.side_speed_max = 400}, 3000, 600).side, 58, 1);
  EXPECT_NEAR(command({.side_speed_max = 400}, 3000, -600).side, -58, 1);
  EXPECT_EQ(command({.side_speed_max = 20}, 3000, 600).side, 20);
}

}  // namespace lab_course_test
}  // namespace rack::pilot
