#include "tools/plot/trajectory_files.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::plot {
namespace trajectory_files_test {

using testing::HasSubstr;
using testing::SizeIs;

Picture read(std::string_view text, std::string_view name = {}) {
  Picture picture;
  const auto good = add_file(text, name, picture);
  EXPECT_TRUE(good) << good.error().detail();
  return picture;
}
std::string refusal(std::string_view text) {
  Picture picture;
  const auto good = add_file(text, {}, picture);
  return good ? "" : good.error().detail();
}

TEST(TrajectoryFiles, RecordingsOfDatalog) {
  const Picture picture = read(
      "% Position(0/0)\n% recordingTime pos.x pos.y pos.z pos.phi pos.psi pos.rho var.x\n"
      "1000 10 20 0 0 0 0.5 1\n1050 12 21 0 0 0 0.5 1\n");
  ASSERT_THAT(picture.trajectories, SizeIs(1));
  EXPECT_EQ(picture.trajectories[0].name, "Position(0/0)");
  EXPECT_EQ(picture.trajectories[0].role, Role::kEstimate);
  EXPECT_DOUBLE_EQ(picture.trajectories[0].times[1], 1.05);
  EXPECT_EQ(picture.trajectories[0].points[1].x, 12);
  const Picture odometry = read("% Odometry(0/0)\n% recordingTime pos.x pos.y\n1 2 3\n");
  EXPECT_EQ(odometry.trajectories.at(0).role, Role::kOdometry);
  const Picture chassis = read("% Chassis(0/0)\n% recordingTime vx\n1000 500\n");
  EXPECT_EQ(chassis.series.at(0).unit, "m/s");
  EXPECT_DOUBLE_EQ(chassis.series.at(0).values.at(0), 0.5);
}

constexpr const char* kPathHead =
    "% Path(0/0)\n% recordingTime splineNum spline[0].basepoint.x spline[0].startPos.x "
    "spline[0].startPos.y spline[0].startPos.rho spline[0].length spline[0].radius\n";

TEST(TrajectoryFiles, ReadsTheLastPath) {
  // A metre north, then a quarter of a circle of 1 m to the right.
  const Picture picture = read(std::string(kPathHead) +
                               "1 1 0 5 5 0 100 0\n2 2 0 0 0 0 1000 0 0 1000 0 0 1571 1000\n3 0\n");
  ASSERT_THAT(picture.trajectories, SizeIs(1));
  EXPECT_EQ(picture.trajectories[0].role, Role::kPath);
  const MapPoint end = picture.trajectories[0].points.back();
  EXPECT_NEAR(end.x, 2000, 1);
  EXPECT_NEAR(end.y, 1000, 1);
  EXPECT_THAT(refusal(std::string(kPathHead) + "1 2 0 5 5 0 100 0\n"), HasSubstr("line 3"));
  EXPECT_THAT(refusal(std::string(kPathHead) + "1 -1\n"), HasSubstr("line 3"));
  EXPECT_THAT(refusal(std::string(kPathHead) + "1 1e30\n"), HasSubstr("line 3"));
  EXPECT_THAT(refusal(kPathHead), HasSubstr("no path"));
}

TEST(TrajectoryFiles, ColumnsWithNames) {
  const Picture picture = read(
      "# by mcl-eval\ntime_s,x_m,y_m,odometry_x_m,odometry_y_m,truth_x_m,truth_y_m,error_m,"
      "error_deg\n0.5,1,2,1.5,2.5,1,2,0.01,0.3\n0.6,2,2,2.5,2.5,,,,\n");
  ASSERT_THAT(picture.trajectories, SizeIs(3));
  EXPECT_EQ(picture.trajectories[0].name, "estimate");
  EXPECT_EQ(picture.trajectories[1].name, "odometry");
  EXPECT_EQ(picture.trajectories[1].points[0].x, 1500);
  EXPECT_EQ(picture.trajectories[2].role, Role::kTruth);
  EXPECT_THAT(picture.trajectories[2].points, SizeIs(1)) << "fields may be empty";
  ASSERT_THAT(picture.series, SizeIs(2));
  EXPECT_EQ(picture.series[0].name, "position error");
  EXPECT_EQ(picture.series[1].unit, "degrees");
  EXPECT_THAT(picture.series[0].values, SizeIs(1));
  // As `timsctl msg echo -o csv` writes them.
  const Picture echo = read("time,src,recordingTime,pos.x,pos.y\na,\"Mcl(0/0)\",100,5,6\n", "mcl");
  EXPECT_EQ(echo.trajectories.at(0).name, "mcl");
  EXPECT_DOUBLE_EQ(echo.trajectories.at(0).times.at(0), 0.1);
  EXPECT_EQ(read("x_m;y_m\n1;2\n", "truth").trajectories.at(0).role, Role::kTruth);
}

TEST(TrajectoryFiles, PosesOfPublicDataSets) {
  const Picture picture = read("1.5 0 3 4 0.1\n1.6 1 3 5 0.1\n");
  ASSERT_THAT(picture.trajectories, SizeIs(1));
  EXPECT_EQ(picture.trajectories[0].role, Role::kTruth);
  EXPECT_EQ(picture.trajectories[0].points[0].x, 4000) << "y of ROS is to the north";
  EXPECT_EQ(picture.trajectories[0].points[0].y, 3000);
  EXPECT_THAT(refusal("1 2 3 4\n1 2\n"), HasSubstr("line 2"));
}

TEST(TrajectoryFiles, LogsOfCarmen) {
  const Picture picture =
      read("# log\nFLASER 3 1.0 1.0 1.0 2.0 3.0 0.0 2.0 3.0 0.0 10.0 host 0.1\n", "");
  EXPECT_EQ(picture.trajectories.at(0).role, Role::kOdometry);
  EXPECT_EQ(picture.trajectories.at(0).points.at(0).x, 3000);
}

TEST(TrajectoryFiles, RefusesWhatIsNone) {
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
  EXPECT_THAT(refusal("# nothing\n"), HasSubstr("empty"));
  EXPECT_THAT(refusal("what is this\n1 2 3\n"), HasSubstr("no columns"));
  EXPECT_THAT(refusal("time_s,x_m,y_m\n1,2,nan\n"), HasSubstr("line 2: \"nan\" is not a number"));
  EXPECT_THAT(refusal("time_s,x_m,y_m\n1,two,3\n"), HasSubstr("line 2: \"two\""));
  EXPECT_THAT(refusal("% Position(0/0)\n1 2 3\n"), HasSubstr("line 2"));
}

// For arbitrary bytes, reading terminates and the output is valid SVG.
TEST(TrajectoryFiles, SurvivesMutations) {
  const std::string texts[] = {std::string(kPathHead) + "2 2 0 0 0 0 1000 0 0 1000 0 0 1571 1000\n",
                               "time_s,x_m,y_m,error_m\n0.5,1,2,0.01\n0.6,2,2,\n",
                               "1.5 0 3 4 0.1\n1.6 1 3 5 0.1\n"};
  std::uint32_t state = 1;
  const auto random = [&] { return state = state * 1664525U + 1013904223U, state >> 8U; };
  for (int round = 0; round < 3000; ++round) {
    std::string text = texts[random() % 3];
    for (std::uint32_t i = 0; i <= random() % 4; ++i)
      text[random() % text.size()] = "0123456789.,e- \n%x"[random() % 18];
    Picture picture;
    if (!add_file(text, {}, picture)) continue;
    EXPECT_EQ(to_svg(picture).find("nan"), std::string::npos) << text;
  }
}

}  // namespace trajectory_files_test
}  // namespace rack::plot
