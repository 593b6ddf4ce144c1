// What PathRDDF does about people on its path: in a room with a door, seen by a scanner.
#include "components/path/route_planner.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::path {
namespace route_planner_test {

using testing::HasSubstr;

constexpr Pose kGoal{.x = 4000, .y = 0};

// A corridor of 2.4 m from x = -1 m to 9 m.
class RoutePlannerTest : public testing::Test {
 protected:
  RoutePlannerTest() {
    begin();
    planner_.take_position({});
  }

  // As when the component is turned on: the position is not known yet.
  void begin() {
    auto space = FreeSpace::empty({-1000, -1200}, 10000, 2400, 50);
    space->occupy({-1000, -1200}, {9000, -1200});
    space->occupy({-1000, 1150}, {9000, 1150});
    space->measure();
    RouteSettings settings;
    ChassisParamData& chassis = settings.chassis;
    chassis.vxMax = 1000;
    chassis.accMax = chassis.decMax = 700;
    chassis.omegaMax = 1;
    chassis.safetyMargin = 100;
    chassis.boundaryFront = chassis.boundaryBack = 250;
    chassis.boundaryLeft = chassis.boundaryRight = 200;
    settings.limits = {};
    settings.limits.half_width = 200;
    EXPECT_TRUE(planner_.begin(settings, {*space}));
    EXPECT_TRUE(planner_.begin_route());
  }

  // A scan from the origin: people of 400 mm, or nothing up to 8 m.
  void see(const std::vector<Place>& people) {
    Scan2dData scan;
    for (int degree = -90; degree <= 90; ++degree) {
      const double angle = radians(static_cast<double>(degree));
      double range = 8000;
      for (const Place& person : people) {
        const double along = person.x * std::cos(angle) + person.y * std::sin(angle);
        const double across = person.y * std::cos(angle) - person.x * std::sin(angle);
        if (along > 0 && std::abs(across) < 200) range = std::min(range, along);
      }
      scan.points.push_back({.x = whole_millimetres(range * std::cos(angle)),
                             .y = whole_millimetres(range * std::sin(angle)),
                             .z = whole_millimetres(range)});
    }
    planner_.take_scan(scan);
  }

  // Steps until the plan is done. Returns the failures.
  std::string plan() {
    std::string failures;
    for (int i = 0; i < 200; ++i) {
      now_ = now_ + std::chrono::milliseconds(50);
      if (const auto failure = planner_.step(now_, path_)) failures += *failure;
    }
    return failures;
  }
  [[nodiscard]] bool leads_to_the_goal() const {
    if (path_.splines.empty()) return false;
    const Position2d& end = path_.splines.back().endPos;
    return std::hypot(end.x - kGoal.x, end.y - kGoal.y) < 50;
  }
  tims::Result<void> send() {
    const Position3d at = kGoal.position();
    return planner_.set_destination({.pos = {at.x, at.y, at.rho}, .speed = 0}, {});
  }

  RoutePlanner planner_;
  PathData path_;
  TimeStamp now_ = 1000;
  const std::vector<Place> barrier_ = {
      {2000, -900}, {2000, -450}, {2000, 0}, {2000, 450}, {2000, 900}};
};

TEST_F(RoutePlannerTest, PlansAroundAPerson) {
  see({{2000, 0}});
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  ASSERT_TRUE(leads_to_the_goal());
  EXPECT_GT(path_.splines.size(), 1U) << "a straight line leads through the person";
}

TEST_F(RoutePlannerTest, PeopleWhoFillTheCorridorMayGo) {
  see(barrier_);
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  EXPECT_TRUE(leads_to_the_goal());
}

TEST_F(RoutePlannerTest, APersonAtTheGoalMayGo) {
  see({{4000, 0}});
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  EXPECT_TRUE(leads_to_the_goal());
}

TEST_F(RoutePlannerTest, ThePathStaysWhenThereIsNoneAroundPeople) {
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  const TimeStamp made = path_.recordingTime;
  see(barrier_);
  const auto replanned = planner_.replan({});
  const std::string failure = plan();
  EXPECT_TRUE(!replanned || !failure.empty());
  EXPECT_EQ(path_.recordingTime, made);
  EXPECT_TRUE(leads_to_the_goal());

  see({});
  ASSERT_TRUE(planner_.replan({}));
  EXPECT_EQ(plan(), "");
  EXPECT_NE(path_.recordingTime, made) << "they have gone";
  EXPECT_TRUE(leads_to_the_goal());
}

TEST_F(RoutePlannerTest, AWallIsNoPerson) {
  const auto refused = planner_.set_destination({.pos = {.x = 4000, .y = 1150}, .speed = 0}, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail(), HasSubstr("no room"));
}

TEST_F(RoutePlannerTest, PlansAsSoonAsItsPositionIsKnown) {
  begin();
  EXPECT_FALSE(planner_.replan({}));
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  EXPECT_TRUE(path_.splines.empty());
  planner_.take_position({});
  EXPECT_EQ(plan(), "");
  EXPECT_TRUE(leads_to_the_goal());

  begin();
  ASSERT_TRUE(planner_.set_destination({.pos = {.x = 20000}}, {}));
  planner_.take_position({});
  EXPECT_THAT(plan(), HasSubstr("outside of the map"));
  EXPECT_TRUE(path_.splines.empty()) << "the pilot learns that there is none";
}

}  // namespace route_planner_test
}  // namespace rack::path
