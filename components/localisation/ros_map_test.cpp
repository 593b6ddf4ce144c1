#include "components/localisation/ros_map.h"

#include <gtest/gtest.h>

namespace rack::localisation {

namespace ros_map_test {

constexpr std::string_view kYaml =
    "image: \"a map.pgm\"  # beside\nresolution: 0.1\norigin: [-1.5, 2.0, 0.0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST(RosMap, ReadsItsDescription) {
  const auto info = read_ros_yaml(kYaml);
  ASSERT_TRUE(info.ok()) << info.error().detail();
  EXPECT_EQ(info->image, "a map.pgm");
  EXPECT_DOUBLE_EQ(info->resolution, 0.1);
  EXPECT_DOUBLE_EQ(info->origin_x, -1.5);
  EXPECT_DOUBLE_EQ(info->origin_y, 2.0);
}

// As programs write it: lists a number a line, quotes, carriage returns, other modes.
TEST(RosMap, ReadsWhatOthersWrite) {
  const auto info = read_ros_yaml(
      "---\r\n# made\r\nimage: '/maps/a b.pgm'\r\nmode: \"scale\"\r\nresolution: 5e-2\r\n"
      "origin:\r\n  - -12.5  # x\r\n  - +3\r\n  - 0.0\r\nnegate: false\r\n...\r\n");
  ASSERT_TRUE(info.ok()) << info.error().detail();
  EXPECT_EQ(info->image, "/maps/a b.pgm");
  EXPECT_DOUBLE_EQ(info->origin_x, -12.5);
  EXPECT_DOUBLE_EQ(info->origin_y, 3);
  const auto raw = read_ros_yaml("image: a\nresolution: 1\nmode: raw\n");
  ASSERT_TRUE(raw.ok());
  const auto map = grid_of(*raw, {.width = 4, .height = 1, .values = {0, 100, 255, 40}});
  EXPECT_EQ(map.at(0, 0), Cell::kFree);
  EXPECT_EQ(map.at(0, 1), Cell::kOccupied);
  EXPECT_EQ(map.at(0, 2), Cell::kUnknown);
  EXPECT_EQ(map.at(0, 3), Cell::kUnknown);
}

TEST(RosMap, ReportsWhatIsWrongWithItsDescription) {
  const auto error_of = [](std::string_view text) { return read_ros_yaml(text).error().detail(); };
  EXPECT_EQ(error_of("image: a\nresolution 5\n"), "line 2: expected `key: value`");
  EXPECT_EQ(error_of("resolution: fine\n"), "line 1: resolution: not a number");
  EXPECT_EQ(error_of("image: a\n\norigin: [1, 2]\n"), "line 3: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("origin: [1, 2, 0.5]\n").substr(0, 7), "line 1:");
  EXPECT_EQ(error_of("mode: grey\n"), "line 1: mode: must be trinary, scale or raw");
  EXPECT_EQ(error_of("origin:\n- 1\n- 2\nimage: a\n"), "line 4: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("origin:\n- 1\n"), "origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("origin:\n- 1\n- x\n- 0\n"), "line 4: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("size:\n- 1\n").substr(0, 7), "line 2:");
  EXPECT_EQ(error_of("negate: maybe\n"), "line 1: negate: must be 0 or 1");
  EXPECT_NE(error_of("resolution: 0.1\n").find("no `image"), std::string::npos);
  EXPECT_NE(error_of("image: a\n").find("no `resolution"), std::string::npos);
  EXPECT_NE(error_of("image: a\nresolution: nan\n").find("line 2"), std::string::npos);
  EXPECT_FALSE(read_ros_yaml("image: a\nresolution: 0.1\norigin: [1e9, 0, 0]\n").ok());
}

// ROS: x to the right, y up; RACK: x to the north, y to the east.
TEST(RosMap, ItsLowestRowIsTheOneMostToTheSouth) {
  const auto info = read_ros_yaml(kYaml);
  ASSERT_TRUE(info.ok());
  const auto map =
      grid_of(*info, {.width = 3, .height = 2, .values = {254, 254, 0, 205, 254, 254}});
  EXPECT_EQ(map.rows, 2);
  EXPECT_EQ(map.columns, 3);
  EXPECT_DOUBLE_EQ(map.resolution, 100);
  EXPECT_DOUBLE_EQ(map.origin.x, 2000);
  EXPECT_DOUBLE_EQ(map.origin.y, -1500);
  EXPECT_EQ(map.at(1, 2), Cell::kOccupied);
  EXPECT_EQ(map.at(0, 0), Cell::kUnknown);
  EXPECT_EQ(map.count(Cell::kFree), 4U);
}

TEST(RosMap, NegatedAndWithSixteenBits) {
  RosMapInfo info{.image = "a", .resolution = 0.1, .negate = true};
  auto map = grid_of(info, {.width = 2, .height = 1, .white = 100, .values = {100, 0}});
  EXPECT_EQ(map.at(0, 0), Cell::kOccupied);
  EXPECT_EQ(map.at(0, 1), Cell::kFree);
  info.negate = false;
  map = grid_of(info, {.width = 2, .height = 1, .white = 65535, .values = {65535, 1}});
  EXPECT_EQ(map.at(0, 0), Cell::kFree);
  EXPECT_EQ(map.at(0, 1), Cell::kOccupied);
}

TEST(RosMap, PosesThereAndBack) {
  const Pose pose = pose_of_ros(1, 2, kPi / 2);  // looks up in the picture
  EXPECT_DOUBLE_EQ(pose.x, 2000);
  EXPECT_DOUBLE_EQ(pose.y, 1000);
  EXPECT_NEAR(signed_angle(pose.rho), 0, 1e-12);
  const RosPose ros = ros_of_pose(pose_of_ros(-3, 4, -2.5));
  EXPECT_DOUBLE_EQ(ros.x, -3);
  EXPECT_DOUBLE_EQ(ros.y, 4);
  EXPECT_NEAR(ros.theta, -2.5, 1e-12);
  // A step ahead is one in both.
  const Pose ahead = pose_of_ros(0, 0, 0.3) + Pose{.x = 1000};
  EXPECT_NEAR(ros_of_pose(ahead).x, std::cos(0.3), 1e-12);
  EXPECT_NEAR(ros_of_pose(ahead).y, std::sin(0.3), 1e-12);
}

}  // namespace ros_map_test

}  // namespace rack::localisation
