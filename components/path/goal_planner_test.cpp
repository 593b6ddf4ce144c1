#include "components/path/goal_planner.h"

#include <ctime>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/patience.h"

namespace rack::path {
namespace goal_planner_test {

using Progress = GoalPlanner::Progress;

constexpr double kWidth = 40000;  // mm

PlanSettings car() {
  return {.limits = {.speed_max = 2000, .omega_max = 0.8, .radius_min = 3000},
          .hull = {.front = 1700, .back = 600, .half_width = 600, .margin = 50}};
}
PlanSettings robot() {
  return {.limits = {.speed_max = 1000, .omega_max = 0.8},
          .hull = {.front = 250, .back = 250, .half_width = 250, .margin = 50}};
}

// Boxes and walls in a field of 40 m by 40 m.
FreeSpace field(std::mt19937& random, int obstacles, double cell) {
  std::uniform_real_distribution<double> any(0, 1);
  auto space = FreeSpace::empty({}, kWidth, kWidth, cell);
  for (int i = 0; i < obstacles; ++i) {
    const Place at{any(random) * kWidth, any(random) * kWidth};
    const double angle = any(random) * kPi;
    const double length = 500 + any(random) * 6000;
    space->occupy(at, {at.x + length * std::cos(angle), at.y + length * std::sin(angle)});
  }
  space->measure();
  return *space;
}

Pose free_pose(const FreeSpace& space, const HullDiscs& hull, std::mt19937& random) {
  std::uniform_real_distribution<double> any(0, 1);
  for (;;) {
    const Pose at{
        .x = any(random) * kWidth, .y = any(random) * kWidth, .rho = any(random) * 2 * kPi};
    if (space.room(hull, at) > 0 && space.clearance({at.x, at.y}) > hull.turning_radius())
      return at;
  }
}

// Every place of the bare hull, on a raster, against every cell.
bool hits(const FreeSpace& space, const HullDiscs::Size& hull, const Pose& at) {
  const double c = std::cos(at.rho);
  const double s = std::sin(at.rho);
  const double step = space.cell() / 2;
  for (double x = -hull.back;; x = std::min(x + step, hull.front)) {
    for (double y = -hull.half_width;; y = std::min(y + step, hull.half_width)) {
      if (space.occupied({at.x + x * c - y * s, at.y + x * s + y * c})) return true;
      if (y >= hull.half_width) break;
    }
    if (x >= hull.front) return false;
  }
}

void expect_free(const std::vector<PolarSpline>& path, const FreeSpace& space,
                 const PlanSettings& settings, const Pose& start, const Pose& goal) {
  ASSERT_FALSE(path.empty());
  Pose before = pose_at(path.front(), 0);
  EXPECT_LT(std::hypot(before.x - start.x, before.y - start.y), 3);
  for (const PolarSpline& spline : path) {
    if (spline.radius != 0) {
      EXPECT_GE(std::abs(static_cast<double>(spline.radius)), settings.limits.radius_min);
    }
    const Pose first = pose_at(spline, 0);
    EXPECT_LT(std::hypot(first.x - before.x, first.y - before.y), 4);
    // Turning at rest, where it does.
    const double turn = signed_angle(first.rho - before.rho);
    if (settings.limits.radius_min > 0) {
      EXPECT_LT(std::abs(turn), 0.01);
    }
    for (int part = 1; part < 8; ++part)
      ASSERT_FALSE(hits(space, settings.hull,
                        {.x = first.x, .y = first.y, .rho = before.rho + turn * part / 8}));
    for (double distance = 0; distance < size(spline); distance += 100)
      ASSERT_FALSE(hits(space, settings.hull, pose_at(spline, sense(spline) * distance)));
    before = pose_at(spline, spline.length);
  }
  EXPECT_FALSE(hits(space, settings.hull, before));
  EXPECT_LT(std::hypot(before.x - goal.x, before.y - goal.y), 15);
  EXPECT_LT(std::abs(signed_angle(before.rho - goal.rho)), 0.02);
  EXPECT_EQ(path.front().vStart, 0);
  EXPECT_EQ(path.back().vEnd, 0);
}

Progress search(GoalPlanner& planner) {
  Progress progress = planner.advance();
  for (int i = 0; i < 1000 && progress == Progress::kSearching; ++i) progress = planner.advance();
  return progress;
}

struct Figures {
  int found = 0;
  std::vector<double> times;  // ms
  [[nodiscard]] double percentile(double part) {
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(part * static_cast<double>(times.size() - 1))];
  }
};

constexpr int kRounds = tims::test::rounds(200);

Figures plan_often(const PlanSettings& settings, int rounds, int obstacles, double cell) {
  std::mt19937 random(11);
  GoalPlanner planner(settings);
  const HullDiscs hull(settings.hull);
  Figures figures;
  for (int round = 0; round < rounds; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const FreeSpace space = field(random, obstacles, cell);
    const Pose start = free_pose(space, hull, random);
    const Pose goal = free_pose(space, hull, random);
    const std::clock_t begin = std::clock();
    const auto good = planner.begin(space, start, goal);
    EXPECT_TRUE(good.ok()) << good.error().detail();
    if (!good) continue;
    const bool found = search(planner) == Progress::kFound;
    figures.times.push_back(static_cast<double>(std::clock() - begin) * 1000 / CLOCKS_PER_SEC);
    if (!found) {
      EXPECT_FALSE(planner.why().empty());
      continue;
    }
    ++figures.found;
    expect_free(planner.path(), space, settings, start, goal);
    if (::testing::Test::HasFailure()) break;
  }
  return figures;
}

TEST(GoalPlanner, LeadsACarThroughFreeSpaceOnly) {
  Figures figures = plan_often(car(), kRounds, 40, 100);
  EXPECT_GT(figures.found, kRounds * 0.85);
  EXPECT_LT(figures.percentile(0.95), 100 * tims::test::kSlowdown) << "CPU time, ms";
  std::cout << "car: " << figures.found << " of " << kRounds << ", ms median "
            << figures.percentile(0.5) << " p95 " << figures.percentile(0.95) << " max "
            << figures.percentile(1) << "\n";
}

TEST(GoalPlanner, LeadsARobotThroughFreeSpaceOnly) {
  Figures figures = plan_often(robot(), kRounds, 60, 100);
  EXPECT_GT(figures.found, kRounds * 0.95);
  std::cout << "robot: " << figures.found << " of " << kRounds << ", ms median "
            << figures.percentile(0.5) << " p95 " << figures.percentile(0.95) << " max "
            << figures.percentile(1) << "\n";
}

TEST(GoalPlanner, ReportsWhyThereIsNoPlan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const PlanSettings& settings : {car(), robot()}) {
    GoalPlanner planner(settings);
    auto space = FreeSpace::empty({}, 20000, 20000, 100);
    // A wall along the whole map.
    space->occupy({10000, 0}, {10000, 20000});
    space->measure();
    const Pose here{.x = 5000, .y = 10000};
    EXPECT_FALSE(planner.begin(*space, here, {.x = 50000, .y = 0}).ok());
    EXPECT_FALSE(planner.begin(*space, {.x = -1}, here).ok());
    EXPECT_FALSE(planner.begin(*space, here, {.x = nan}).ok());
    EXPECT_FALSE(planner.begin(*space, here, {.x = 10000, .y = 10000}).ok()) << "in the wall";
    ASSERT_TRUE(planner.begin(*space, here, {.x = 15000, .y = 10000}).ok());
    EXPECT_EQ(search(planner), Progress::kFailed);
    EXPECT_NE(planner.why().find("(15000, 10000)"), std::string::npos);
    EXPECT_TRUE(planner.path().empty());
    // A door in it.
    for (double y = 9000; y < 12000; y += 50) space->release({10000, y});
    space->measure();
    ASSERT_TRUE(planner.begin(*space, here, {.x = 15000, .y = 10000}).ok());
    EXPECT_EQ(search(planner), Progress::kFound) << planner.why();
  }
}

// Wherever it stands and goes in an empty field there is a plan, also to where it is.
TEST(GoalPlanner, FindsShortPaths) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const PlanSettings& settings : {car(), robot()}) {
    GoalPlanner planner(settings);
    auto space = FreeSpace::empty({-20000, -20000}, 40000, 40000, 100);
    ASSERT_TRUE(space.ok());
    for (int i = 0; i < 300; ++i) {
      const double far = i % 3 == 0 ? 20 : 3000;
      const Pose start{.x = any(random) * 100, .y = any(random) * 100, .rho = any(random) * 4};
      const Pose goal{.x = any(random) * far, .y = any(random) * far, .rho = any(random) * 4};
      ASSERT_TRUE(planner.begin(*space, start, goal).ok());
      ASSERT_EQ(search(planner), Progress::kFound) << i << " " << planner.why();
      expect_free(planner.path(), *space, settings, start, goal);
    }
  }
}

TEST(GoalPlanner, GoesThroughADoorWhereItCannotTurn) {
  auto space = FreeSpace::empty({}, 6000, 6000, 20);
  space->occupy({3000, 0}, {3000, 2650});
  space->occupy({3000, 3350}, {3000, 6000});
  space->measure();
  GoalPlanner planner(robot());
  const Pose start{.x = 1000, .y = 1000};
  const Pose goal{.x = 5000, .y = 5000, .rho = 1};
  ASSERT_TRUE(planner.begin(*space, start, goal).ok());
  ASSERT_EQ(search(planner), Progress::kFound) << planner.why();
  expect_free(planner.path(), *space, robot(), start, goal);
}

TEST(GoalPlanner, DrivesBackwardWhenItShall) {
  auto space = FreeSpace::empty({}, 20000, 20000, 100);
  ASSERT_TRUE(space.ok());
  for (const PlanSettings& settings : {car(), robot()}) {
    GoalPlanner planner(settings);
    ASSERT_TRUE(planner.begin(*space, {.x = 12000, .y = 10000}, {.x = 6000, .y = 10000}, -1).ok());
    ASSERT_EQ(search(planner), Progress::kFound);
    for (const PolarSpline& spline : planner.path()) EXPECT_LT(spline.length, 0);
  }
}

// 5 m x 5 m without obstacles; cells of 20 mm.
FreeSpace room_of_5_m() {
  auto space = FreeSpace::empty({}, 5000, 5000, 20);
  return *space;
}

std::vector<PolarSpline> path_from(const FreeSpace& space, const Pose& start, const Pose& goal,
                                   const PlanSettings& settings = robot()) {
  GoalPlanner planner(settings);
  const auto begun = planner.begin(space, start, goal);
  EXPECT_TRUE(begun) << begun.error().message();
  if (!begun || search(planner) != Progress::kFound) return {};
  return planner.path();
}

// The margin is 50 mm: with it, the hull turns within 404 mm.
TEST(GoalPlanner, LeavesAPersonWhoHasComeWithinItsMargin) {
  FreeSpace space = room_of_5_m();
  const Pose start{.x = 2500, .y = 2500};
  space.occupy_area({2400, 2100}, {2600, 2150});
  space.measure();
  const auto path = path_from(space, start, {.x = 4000, .y = 4000});
  ASSERT_FALSE(path.empty());
  double nearest = space.clearance({start.x, start.y});
  for (const PolarSpline& spline : path)
    for (double at = 0; at < size(spline); at += 50) {
      const Pose pose = pose_at(spline, sense(spline) * at);
      const double clearance = space.clearance({pose.x, pose.y});
      EXPECT_GE(clearance, nearest - 50);
      nearest = std::min(clearance, 404.0);
    }
}

TEST(GoalPlanner, GoesBackFromWhatItCannotTurnBefore) {
  FreeSpace space = room_of_5_m();
  space.occupy_area({2820, 2300}, {2900, 2700});
  space.measure();
  const auto path = path_from(space, {.x = 2500, .y = 2500}, {.x = 500, .y = 2500, .rho = kPi});
  ASSERT_FALSE(path.empty());
  EXPECT_LT(path.front().length, 0) << "backward";
  EXPECT_GT(path.front().length, -400);
  EXPECT_GT(path.back().length, 0);

  const auto ahead = path_from(space, {.x = 2500, .y = 2000}, {.x = 500, .y = 2500, .rho = kPi});
  ASSERT_FALSE(ahead.empty());
  EXPECT_GT(ahead.front().length, 0) << "it can turn there";
}

// The discs that stand for the hull reach farther than the circle in which it turns.
TEST(GoalPlanner, AcceptsAGoalWhereTheVehicleCanJustTurn) {
  PlanSettings settings = robot();
  settings.hull = {.front = 250, .back = 250, .half_width = 200, .margin = 150};
  const HullDiscs hull(settings.hull);
  const Pose goal{.x = 2500, .y = 2500};
  for (const bool is_enough : {false, true}) {
    FreeSpace space = room_of_5_m();
    const double wall = hull.turning_radius() + (is_enough ? 2 : -1) * space.cell();
    space.occupy_area({2000, goal.y + wall}, {3000, goal.y + wall});
    space.measure();
    GoalPlanner planner(settings);
    const auto begun = planner.begin(space, {.x = 2500, .y = 1000},
                                     {.x = goal.x, .y = goal.y, .rho = radians(90.0)});
    EXPECT_EQ(begun.ok(), is_enough);
    EXPECT_LT(space.clearance({goal.x, goal.y}), hull.reach());
    if (!is_enough) continue;
    EXPECT_EQ(planner.advance(), Progress::kFound) << planner.why();
  }
}

// A wall is 400 mm beside the goal: enough for the hull with its margin, not for turning.
TEST(GoalPlanner, TurnsToTheFinalHeadingWhereThereIsRoomForIt) {
  FreeSpace space = room_of_5_m();
  space.occupy_area({2000, 4000}, {3000, 4050});
  space.measure();
  PlanSettings settings = robot();
  settings.hull = {.front = 400, .back = 400, .half_width = 200, .margin = 50};
  const HullDiscs hull(settings.hull);
  const Pose goal{.x = 2500, .y = 3600};
  const auto path = path_from(space, {.x = 2500, .y = 1000}, goal, settings);
  ASSERT_GE(path.size(), 2U);
  const Pose turns = pose_at(path.back(), 0);
  EXPECT_GE(space.clearance({turns.x, turns.y}), hull.turning_radius());
  EXPECT_NEAR(turns.y, goal.y, 5) << "on the line to the goal";
}

}  // namespace goal_planner_test
}  // namespace rack::path
