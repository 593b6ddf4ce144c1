#include "components/perception/free_memory.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace rack::perception {
namespace free_memory_test {

// A round room of 5 m, with something 300 mm wide at x, 0; half a degree between beams.
ScanView room(double x, const Pose& robot = {}) {
  Scan2dData scan;
  for (int i = -360; i < 360; ++i) {
    const double angle = radians(i * 0.5) + robot.rho;
    const double along = -robot.x * std::cos(angle) - robot.y * std::sin(angle);
    const double beside = robot.x * robot.x + robot.y * robot.y - along * along;
    double range = along + std::sqrt(25e6 - beside);
    const double to = (x - robot.x) / std::cos(angle);
    if (x > 0 && to > 0 && std::abs(robot.y + to * std::sin(angle)) < 150) range = to;
    scan.points.push_back({.x = whole_millimetres(range * std::cos(angle - robot.rho)),
                           .y = whole_millimetres(range * std::sin(angle - robot.rho))});
  }
  ScanView view;
  view.take(scan, {}, 20000);
  view.place(robot);
  return view;
}

long moved(const ScanView& view) { return std::ranges::count_if(view.sights(), &Sight::moved); }

// Ten scans a second from then until `end`. Returns the number of
// sights of the last one that have moved.
long look_until(FreeMemory& memory, double& t, double end, double x, const Pose& robot = {}) {
  long last = 0;
  for (; t < end; t += 0.1) {
    ScanView view = room(x, robot);
    memory.look(view, t);
    last = moved(view);
  }
  return last;
}

TEST(FreeMemory, WhatComesWhereItWasFreeHasMoved) {
  FreeMemory memory;
  double t = 0;
  for (; t < 2; t += 0.1) {
    ScanView empty = room(0);
    memory.look(empty, t);
    EXPECT_EQ(moved(empty), 0);
  }
  ScanView come = room(2000);
  memory.look(come, t);
  EXPECT_GT(moved(come), 10);
  const auto thing = std::ranges::find_if(come.sights(), &Sight::moved);
  EXPECT_EQ(thing->stood, 0);
  EXPECT_NEAR(thing->away, 2000, 20);
}

// A thin leg, met by two scans of three.
TEST(FreeMemory, WhatFlickersHasNotMoved) {
  FreeMemory memory;
  long most = 0;
  for (int i = 0; i < 20; ++i) {
    ScanView now = room(i % 3 == 0 ? 0 : 2000);
    memory.look(now, i * 0.5);
    if (i > 8) most = std::max(most, moved(now));
  }
  EXPECT_EQ(most, 0);
}

TEST(FreeMemory, WhatStaysBecomesPartOfTheRoom) {
  FreeMemory memory;
  double t = 0;
  look_until(memory, t, 2, 0);
  EXPECT_EQ(look_until(memory, t, 12, 2000), 0);
  ScanView stays = room(2000);
  memory.look(stays, t);
  const auto& sights = stays.sights();
  EXPECT_GT(std::ranges::min_element(sights, {}, &Sight::away)->stood, 3);
}

// A scanner of half a turn that looks away, and back.
TEST(FreeMemory, WhatWasSeenLongAgoIsStillKnown) {
  FreeMemory memory;
  double t = 0;
  look_until(memory, t, 3, 0);
  for (; t < 18; t += 0.1) {
    ScanView away = room(0);
    std::erase_if(away.sights(), [](const Sight& sight) { return sight.x > 0; });
    memory.look(away, t);
  }
  ScanView come = room(2000);
  memory.look(come, t);
  EXPECT_GT(moved(come), 10);
  ScanView late = room(2000);
  memory.look(late, t + 15);
  EXPECT_EQ(moved(late), 0) << "too long ago";
}

TEST(FreeMemory, ANewObjectHasNotStoodAsLongAsTheLastOne) {
  FreeMemory memory;
  double t = 0;
  look_until(memory, t, 3, 0);
  look_until(memory, t, 5, 2000);
  look_until(memory, t, 8, 0);
  ScanView next = room(2000);
  memory.look(next, t);
  const auto& sights = next.sights();
  EXPECT_EQ(std::ranges::min_element(sights, {}, &Sight::away)->stood, 0);
}

TEST(FreeMemory, WhatIsRevealedHasNotMoved) {
  FreeMemory memory;
  double t = 0;
  look_until(memory, t, 2, 2000);
  ScanView gone = room(0);
  memory.look(gone, t);
  EXPECT_EQ(moved(gone), 0);
}

TEST(FreeMemory, AScanIsLaidOnThoseBefore) {
  FreeMemory memory;
  double t = 0;
  const Pose at{.x = 1500, .y = 800, .rho = 0.3};
  look_until(memory, t, 2, 3000, at);
  const ScanView view = room(3000, at);
  const Pose wrong = at + Pose{.x = 90, .y = -70, .rho = radians(0.5)};
  const Pose found = memory.lay_on(view, wrong);
  EXPECT_LT(std::hypot(found.x - at.x, found.y - at.y), 60);
  EXPECT_LT(std::hypot(found.x - at.x, found.y - at.y),
            std::hypot(wrong.x - at.x, wrong.y - at.y) / 2);
}

TEST(FreeMemory, AfterForgettingNothingIsKnown) {
  FreeMemory memory;
  double t = 0;
  look_until(memory, t, 2, 0);
  memory.forget();
  ScanView come = room(2000);
  memory.look(come, t);
  EXPECT_EQ(moved(come), 0);
}

}  // namespace free_memory_test
}  // namespace rack::perception
