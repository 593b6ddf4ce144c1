#include "components/scan3d/frame.h"

#include <gtest/gtest.h>

#include "components/scan3d/trajectory.h"

namespace rack::scan3d {
namespace frame_test {

void expect_at(const Place& place, const Place& wanted) {
  EXPECT_NEAR(place.x, wanted.x, 1e-9);
  EXPECT_NEAR(place.y, wanted.y, 1e-9);
  EXPECT_NEAR(place.z, wanted.z, 1e-9);
}

TEST(Frame, TurnsClockwiseAlongItsAxes) {
  expect_at(Frame::about_z(kPi / 2) * Place{1, 0, 0}, {0, 1, 0});   // to the right
  expect_at(Frame::about_y(kPi / 2) * Place{1, 0, 0}, {0, 0, -1});  // upwards
  expect_at(Frame::about_x(kPi / 2) * Place{0, 1, 0}, {0, 0, 1});   // right side down
}

TEST(Frame, RollsThenPitchesThenTurnsThenMoves) {
  const Frame frame(Pose{.x = 10, .y = 20, .z = 30, .phi = 0.1, .psi = 0.2, .rho = 0.3});
  const Frame alike = Frame(Pose{.x = 10, .y = 20, .z = 30}) * Frame::about_z(0.3) *
                      Frame::about_y(0.2) * Frame::about_x(0.1);
  const Place place{4, 5, 6};
  expect_at(frame * place, alike * place);
  expect_at(frame.inverse() * (frame * place), place);
  // In the plane it is what poses do.
  const Pose robot{.x = 100, .y = -50, .rho = 2};
  const Pose local{.x = 7, .y = 8};
  const Pose there = robot + local;
  expect_at(Frame(robot) * Place{7, 8, 0}, {there.x, there.y, 0});
}

TEST(Track, IsKnownBetweenItsSamplesOnly) {
  Trajectory<double> track;
  EXPECT_FALSE(track.at(1000, 0));
  EXPECT_TRUE(track.add(1000, 0.1));
  EXPECT_TRUE(track.add(1100, 0.3));
  EXPECT_FALSE(track.at(999, 0.9));
  EXPECT_DOUBLE_EQ(*track.at(1000, 0), 0.1);
  EXPECT_NEAR(*track.at(1050, 0.5), 0.201, 1e-9);
  EXPECT_DOUBLE_EQ(*track.at(1150, -50), 0.3);
  EXPECT_FALSE(track.at(1100, 0.1));
}

TEST(Track, TakesSamplesInAnyOrderAndTwice) {
  Trajectory<double> track;
  for (const u32 time : {1000U, 1300U, 1100U, 1200U, 1300U, 900U, 1100U})
    EXPECT_TRUE(track.add(time, time / 10000.0));
  for (double ms = 0; ms <= 400; ms += 12.5)
    EXPECT_NEAR(*track.at(900, ms), (900 + ms) / 10000, 1e-12) << ms;
}

TEST(Track, KeepsTheNewest) {
  Trajectory<double> track;
  u32 time = 4294960000U;  // over the end of the counter
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(track.add(time += 20, i * 0.01));
  EXPECT_NEAR(*track.at(time, -50), 9.965, 1e-9);
  EXPECT_NEAR(*track.at(time, -255 * 20), 7.44, 1e-9);
  EXPECT_FALSE(track.at(time, -256 * 20));
  EXPECT_FALSE(track.add(time - 256 * 20, 1)) << "older than all";
  EXPECT_TRUE(track.add(time - 30, 9.975)) << "between";
  EXPECT_NEAR(*track.at(time, -30), 9.975, 1e-9);
}

TEST(Track, DoesNotBridgePausesAndSteps) {
  Trajectory<double> track;
  track.add(1000, 0.1);
  track.add(1600, 0.1);
  EXPECT_FALSE(track.at(1300, 0)) << "the pause between the samples is too long";
  track.add(1650, 3);
  EXPECT_FALSE(track.at(1625, 0)) << "nothing turns like that";
  EXPECT_TRUE(track.at(1650, 0));
  EXPECT_FALSE(track.add(1700, NAN));
  EXPECT_FALSE(track.add(1700, INFINITY));
  EXPECT_FALSE(track.add(1700, 1e9));

  Trajectory<Pose> poses;
  poses.add(1000, {.rho = 6.2});
  poses.add(1050, {.x = 100, .rho = 0.1});
  EXPECT_NEAR(poses.at(1025, 0)->rho, 0.008, 0.001) << "by the smaller angle";
  poses.add(1100, {.x = 5000, .rho = 0.1});
  EXPECT_FALSE(poses.at(1075, 0)) << "the pose was set";
  EXPECT_FALSE(poses.add(1200, {.psi = NAN}));
}

TEST(Track, BeginsAgainWhenAClockIsSet) {
  Trajectory<double> track;
  track.add(50'000, 0.1);
  track.add(20'000, 0.2);
  track.add(20'100, 0.3);
  EXPECT_TRUE(track.at(20'050, 0));
  EXPECT_FALSE(track.at(50'000, 0));
}

}  // namespace frame_test
}  // namespace rack::scan3d
