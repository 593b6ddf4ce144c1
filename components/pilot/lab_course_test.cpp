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
  LabCourse course{indoor_chassis()};
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

}  // namespace lab_course_test
}  // namespace rack::pilot
