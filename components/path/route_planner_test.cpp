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
    begin_in(*space);
  }
  void begin_in(const FreeSpace& space) {
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
    EXPECT_TRUE(planner_.begin(settings, {space}));
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
  // Of a pilot that does not know where on the path it is: it cannot make room.
  const auto replanned = planner_.replan({.currSpline = 99});
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

// A corridor of 1 m with a bay: only there can a person pass.
class RoutePlannerMakesRoom : public RoutePlannerTest {
 protected:
  RoutePlannerMakesRoom() {
    auto space = FreeSpace::empty({-1000, -500}, 10000, 4000, 50);
    space->occupy_area({-1000, -500}, {9000, -500});
    space->occupy_area({-1000, 500}, {500, 3500});
    space->occupy_area({2500, 500}, {9000, 3500});
    space->measure();
    begin_in(*space);
    planner_.take_position({});
    EXPECT_TRUE(send());
    EXPECT_EQ(plan(), "");
    EXPECT_TRUE(leads_to_the_goal());
    drive_to(2600, 0);
    person_ = {3200, 0};
  }

  void drive_to(double x, double y) {
    const Place from = at_;
    for (int i = 1; i <= 40; ++i) {
      at_ = {from.x + (x - from.x) * i / 40, from.y + (y - from.y) * i / 40};
      planner_.take_position({.x = at_.x, .y = at_.y});
    }
  }
  // The person, seen from all around: as PathRDDF sees him at the first look.
  void see_person() {
    Scan2dData scan;
    for (int degree = 0; degree < 360; degree += 10) {
      const double angle = radians(static_cast<double>(degree));
      scan.points.push_back({.x = whole_millimetres(person_.x + 150 * std::cos(angle) - at_.x),
                             .y = whole_millimetres(person_.y + 150 * std::sin(angle) - at_.y)});
    }
    planner_.take_scan(scan);
  }
  // Steps for that time. Returns the failures.
  std::string go_on(std::chrono::milliseconds time) {
    std::string failures;
    for (const TimeStamp end = now_ + time; now_ < end;) {
      now_ = now_ + std::chrono::milliseconds(50);
      if (const auto failure = planner_.step(now_, path_)) failures += *failure;
    }
    return failures;
  }
  // As the pilot does when it is blocked.
  void ask_again() {
    see_person();
    (void)planner_.replan({.distToObstacle = 300, .pathLength = 1400});
    (void)go_on(std::chrono::milliseconds(500));
  }
  // Where the path must not be driven any further.
  [[nodiscard]] Place waits_at() const {
    for (const PolarSpline& spline : path_.splines)
      if (is_waiting(spline)) return {1.0 * spline.startPos.x, 1.0 * spline.startPos.y};
    return {};
  }

  Place at_{};
  Place person_{};
};

TEST_F(RoutePlannerMakesRoom, DrivesAsideAndWaits) {
  ask_again();
  ASSERT_TRUE(planner_.makes_room());
  const Place aside = waits_at();
  EXPECT_GT(aside.y, 500) << "in the bay";
  EXPECT_TRUE(leads_to_the_goal()) << "the pilot must not believe that it has arrived";
  EXPECT_FALSE(is_waiting(path_.splines.front()));
  EXPECT_TRUE(is_waiting(path_.splines.back()));

  drive_to(aside.x, aside.y);
  see_person();
  (void)go_on(std::chrono::seconds(10));
  EXPECT_TRUE(planner_.makes_room()) << "the person is still there";
  EXPECT_TRUE(is_waiting(path_.splines.back()));

  planner_.take_scan({});
  person_ = {-5000, 0};
  see({});
  (void)go_on(std::chrono::seconds(15));
  EXPECT_FALSE(planner_.makes_room());
  EXPECT_TRUE(leads_to_the_goal());
  EXPECT_FALSE(is_waiting(path_.splines.back()));
}

// The bay leads around the block beside the corridor: 17 m in place of 1.4 m.
TEST_F(RoutePlannerMakesRoom, BeforeALongDetour) {
  auto space = FreeSpace::empty({-1000, -500}, 10000, 4000, 50);
  space->occupy_area({-1000, -500}, {9000, -500});
  space->occupy_area({-1000, 500}, {500, 3500});
  space->occupy_area({2500, 500}, {7400, 2400});
  space->occupy_area({8600, 500}, {9000, 3500});
  space->measure();
  begin_in(*space);
  planner_.take_position({});
  ASSERT_TRUE(send());
  EXPECT_EQ(plan(), "");
  drive_to(2600, 0);
  const auto length = [&] {
    double sum = 0;
    for (const PolarSpline& spline : path_.splines) sum += std::abs(1.0 * spline.length.raw());
    return sum;
  };
  EXPECT_LT(length(), 5000);

  ask_again();
  (void)go_on(std::chrono::seconds(5));
  EXPECT_TRUE(planner_.makes_room());
  const Place aside = waits_at();
  drive_to(aside.x, aside.y);
  see_person();
  (void)go_on(std::chrono::seconds(10));
  EXPECT_TRUE(planner_.makes_room()) << "it waits, although there is a way round";

  drive_to(2600, 0);  // as if the person had gone
  (void)go_on(std::chrono::seconds(30));
  ask_again();
  (void)go_on(std::chrono::seconds(10));
  EXPECT_FALSE(planner_.makes_room()) << "once at a place";
  EXPECT_TRUE(leads_to_the_goal());
  EXPECT_GT(length(), 10000);
}

TEST_F(RoutePlannerMakesRoom, DoesNotWaitForEver) {
  ask_again();
  const Place aside = waits_at();
  drive_to(aside.x, aside.y);
  see_person();
  (void)go_on(std::chrono::seconds(19));
  EXPECT_TRUE(planner_.makes_room());
  (void)go_on(std::chrono::seconds(4));
  EXPECT_FALSE(planner_.makes_room());
  EXPECT_TRUE(leads_to_the_goal());
  EXPECT_FALSE(is_waiting(path_.splines.back()));
}

TEST_F(RoutePlannerMakesRoom, AFewTimes) {
  int times = 0;
  for (int i = 0; i < 10; ++i) {
    ask_again();
    if (!planner_.makes_room()) continue;
    ++times;
    const Place aside = waits_at();
    drive_to(aside.x, aside.y);
    see_person();
    (void)go_on(std::chrono::seconds(25));
    EXPECT_FALSE(planner_.makes_room());
    drive_to(2600, 0);
  }
  EXPECT_EQ(times, 5);
  EXPECT_TRUE(leads_to_the_goal()) << "the path stays";
  EXPECT_TRUE(send());
  (void)go_on(std::chrono::seconds(1));
  ask_again();
  EXPECT_TRUE(planner_.makes_room()) << "another destination";
}

TEST_F(RoutePlannerMakesRoom, ANewDestinationEndsIt) {
  ask_again();
  ASSERT_TRUE(planner_.makes_room());
  EXPECT_TRUE(planner_.set_destination({.pos = {.x = 0}}, {}));
  EXPECT_FALSE(planner_.makes_room());
  EXPECT_EQ(go_on(std::chrono::seconds(1)), "");
  EXPECT_FALSE(is_waiting(path_.splines.back()));
}

TEST_F(RoutePlannerMakesRoom, WhoIsBlockedAsideTriesBackward) {
  ask_again();
  ASSERT_GT(path_.splines.front().length, 0);
  ask_again();
  EXPECT_TRUE(planner_.makes_room());
  EXPECT_LT(path_.splines.front().length, 0);
}

}  // namespace route_planner_test
}  // namespace rack::path
