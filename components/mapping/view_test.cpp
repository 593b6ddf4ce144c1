// What scans see of each other's walls.
#include "components/mapping/view.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "components/mapping/building_fixture.h"
#include "components/mapping/doubts.h"
#include "components/mapping/keyframes.h"
#include "components/mapping/moving.h"

namespace rack::mapping {

namespace view_test {

using test::Building;

bool go_on(std::string_view /*what*/, std::size_t /*done*/, std::size_t /*all*/) { return true; }

// A wall across at 4 m, seen from the origin.
std::vector<BeamEnd> wall_ahead() {
  std::vector<BeamEnd> ends;
  for (int degree = -40; degree <= 40; ++degree)
    ends.push_back({4000.0F, static_cast<float>(4000 * std::tan(radians(degree)))});
  return ends;
}

TEST(View, KnowsWhatIsFree) {
  const View view(wall_ahead(), {});
  EXPECT_EQ(view.judge(4000, 0), Seen::kThere);
  EXPECT_EQ(view.judge(4300, 100), Seen::kThere) << "within the errors of poses";
  EXPECT_EQ(view.judge(2000, 0), Seen::kThrough);
  EXPECT_EQ(view.judge(3000, 500), Seen::kThrough);
  EXPECT_EQ(view.judge(6000, 0), Seen::kUnknown) << "behind the wall";
  EXPECT_EQ(view.judge(0, 3000), Seen::kUnknown) << "no beam went there";
  EXPECT_EQ(view.judge(-2000, 0), Seen::kUnknown);
  EXPECT_EQ(view.judge(100, 0), Seen::kUnknown) << "the robot itself";
  EXPECT_EQ(view.judge(std::nan(""), 0), Seen::kUnknown);
  EXPECT_EQ(View().judge(2000, 0), Seen::kUnknown);
}

TEST(View, MovesWithItsScanner) {
  std::vector<BeamEnd> ends = wall_ahead();
  for (BeamEnd& end : ends) end.x += 1000;
  const View view(ends, {.x = 1000});
  EXPECT_EQ(view.judge(5000, 0), Seen::kThere);
  EXPECT_EQ(view.judge(3000, 0), Seen::kThrough);
}

TEST(View, CountsOnlyWalls) {
  const View view(wall_ahead(), {});
  const std::vector<ScanPoint2d> points{
      {2000, 0, -1, 0}, {4000, 0, -1, 0}, {2000, 0, 0, 0}, {9000, 0, -1, 0}};
  const Agreement here = view.judge(points, {});
  EXPECT_EQ(here.seen, 1U);
  EXPECT_EQ(here.seen_through, 1U);
  EXPECT_DOUBLE_EQ(here.contradiction(), 0.5);
  // Two metres further on, the first is the wall.
  const Agreement further = view.judge(points, {.x = 2000});
  EXPECT_EQ(further.seen, 1U);
  EXPECT_EQ(further.seen_through, 0U);
  EXPECT_DOUBLE_EQ(Agreement{}.contradiction(), 0);
}

// A board that is carried two metres ahead of the robot is forgotten, the walls are not.
TEST(Moving, IsForgotten) {
  Building building(3);
  Drive drive = building.drive(6000, 200, 0);
  for (DriveScan& scan : drive.scans)
    for (std::size_t i = 0; i < scan.count; ++i) {
      BeamEnd& end = drive.ends[scan.begin + i];
      const float part = 2000 / end.x;
      if (end.x > 2000 && std::abs(part * end.y) < 300) end = {2000, part * end.y};
    }
  auto track = follow(drive, go_on);
  ASSERT_TRUE(track.has_value());
  for (std::size_t i = 0; i < track->poses.size(); ++i)
    track->poses[i] = building.truth()[track->keyframes[i].scan];
  std::size_t walls = 0;
  for (const Keyframe& keyframe : track->keyframes)
    walls +=
        static_cast<std::size_t>(std::ranges::count_if(keyframe.points, &ScanPoint2d::on_wall));
  const auto boards = [&] {
    const Keyframe& middle = track->keyframes[track->keyframes.size() / 2];
    return std::ranges::count_if(middle.points, [](const ScanPoint2d& p) {
      return p.on_wall() && std::abs(p.x - 2000) < 50 && std::abs(p.y) < 300;
    });
  };
  const auto before = boards();
  const std::size_t forgotten = forget_moving(*track);
  EXPECT_LT(forgotten, walls / 5);
  EXPECT_GT(before, 5);
  // Some are as near to a wall as the errors of poses.
  EXPECT_LT(boards(), before);
  EXPECT_EQ(forget_moving(*track), 0U);
}

// True poses contradict nothing; a second round that is drawn a metre beside the first one does.
TEST(Doubts, FindWhatIsDrawnTwice) {
  Building building(3);
  const Drive drive = building.drive(80000, 200, 0);
  auto track = follow(drive, go_on);
  ASSERT_TRUE(track.has_value());
  for (std::size_t i = 0; i < track->poses.size(); ++i)
    track->poses[i] = building.truth()[track->keyframes[i].scan];
  const auto fine = find_doubts(*track, go_on);
  ASSERT_TRUE(fine.has_value());
  EXPECT_GT(fine->compared, 20000);
  EXPECT_LT(fine->distance, 1000);
  for (std::size_t i = 0; i < track->poses.size(); ++i)
    if (track->keyframes[i].travelled > 42000) {
      track->poses[i].x += 1100;
      track->poses[i].y -= 1100;
    }
  const auto twice = find_doubts(*track, go_on);
  ASSERT_TRUE(twice.has_value());
  EXPECT_GT(twice->distance, 0.5 * twice->compared);
  EXPECT_FALSE(twice->places.empty());
  EXPECT_FALSE(twice->walls.empty());
  EXPECT_FALSE(find_doubts(*track, [](auto, auto, auto) { return false; }).has_value());
}

}  // namespace view_test

}  // namespace rack::mapping
