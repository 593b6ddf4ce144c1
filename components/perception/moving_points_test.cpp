#include "components/perception/moving_points.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::perception {
namespace moving_points_test {

ObjRecogObject object(i32 x, i32 y, i32 vx, double degrees = 0) {
  ObjRecogObject made{.objectId = 1};
  made.pos.x = x;
  made.pos.y = y;
  made.pos.rho = static_cast<f32>(radians(degrees));
  made.vel.x = vx;
  made.dim = {.x = 2000, .y = 600, .z = 0};
  return made;
}

Scan2dData scan(u32 time, std::vector<ScanPoint> points) {
  Scan2dData data{.recordingTime = time};
  data.points.assign(points.begin(), points.end());
  return data;
}

ObjRecogData objects_of(u32 time, const ObjRecogObject& one) {
  ObjRecogData data{.recordingTime = time};
  data.objects.push_back(one);
  return data;
}

TEST(MovingPoints, InsideTheTurnedBoxOfWhatIsFast) {
  Scan2dData seen = scan(0, {{.x = 3000, .y = 0, .type = 0x80},
                             {.x = 3000, .y = 1050},
                             {.x = 3450, .y = 0},
                             {.x = 3000, .y = 1150},
                             {.x = 3000, .y = 100, .type = scan_point::kInvalid}});
  EXPECT_EQ(mark_moving(objects_of(0, object(3000, 0, 400, 90)), {}, seen), 2U);
  EXPECT_EQ(seen.points[0].type, 0x83) << "what it was, it still is";
  EXPECT_EQ(seen.points[1].type, 3);
  EXPECT_EQ(seen.points[2].type, 0) << "beside it";
  EXPECT_EQ(seen.points[3].type, 0) << "behind it";
  EXPECT_EQ(seen.points[4].type, scan_point::kInvalid);
}

TEST(MovingPoints, SlowOnesDoNotCount) {
  Scan2dData seen = scan(0, {{.x = 3000, .y = 0}});
  EXPECT_EQ(mark_moving(objects_of(0, object(3000, 0, 299)), {}, seen), 0U);
  EXPECT_EQ(mark_moving(objects_of(0, object(3000, 0, -300)), {}, seen), 1U);
}

TEST(MovingPoints, ObjectsGoOnToTheTimeOfTheScan) {
  Scan2dData seen = scan(500, {{.x = 5500, .y = 0}, {.x = 3000, .y = 0}});
  EXPECT_EQ(mark_moving(objects_of(0, object(3000, 0, 4000)), {}, seen), 1U);
  EXPECT_EQ(seen.points[0].type, 3);
  Scan2dData late = scan(1100, {{.x = 7400, .y = 0}});
  EXPECT_EQ(mark_moving(objects_of(0, object(3000, 0, 4000)), {}, late), 0U) << "too old to know";
}

TEST(MovingPoints, TheRobotHasMovedMeanwhile) {
  ObjRecogData objects = objects_of(0, object(3000, 0, 400));
  objects.refPos = Pose{.x = 1000, .y = 1000}.position();
  Scan2dData seen = scan(0, {{.x = 0, .y = -2000}});
  seen.refPos = Pose{.x = 2000, .y = 1000, .rho = radians(90)}.position();
  EXPECT_EQ(mark_moving(objects, {}, seen), 1U);
}

TEST(MovingPoints, NothingOfWhatIsNoNumber) {
  ObjRecogData objects = objects_of(0, object(3000, 0, 400));
  objects.objects[0].pos.rho = std::numeric_limits<f32>::quiet_NaN();
  Scan2dData seen = scan(0, {{.x = 3000, .y = 0}});
  EXPECT_EQ(mark_moving(objects, {}, seen), 0U);
  objects = objects_of(0, object(3000, 0, 400));
  objects.refPos.x = 1;
  objects.refPos.rho = std::numeric_limits<f32>::infinity();
  seen.refPos.x = 2;
  EXPECT_EQ(mark_moving(objects, {}, seen), 0U);
  objects = objects_of(0, object(2147483647, -2147483647, 2147483647));
  EXPECT_EQ(mark_moving(objects, {}, seen), 0U);
}

}  // namespace moving_points_test
}  // namespace rack::perception
