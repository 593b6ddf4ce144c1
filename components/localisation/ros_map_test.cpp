#include "components/localisation/ros_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::localisation {

namespace ros_map_test {

constexpr std::string_view kYaml =
    "image: \"a map.pgm\"  # beside\nresolution: 0.1\norigin: [-1.5, 2.0, 0.0]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST(RosMap, RawValuesArePerCent) {
  const auto raw = read_ros_yaml("image: a\nresolution: 1\nmode: raw\n");
  ASSERT_TRUE(raw.ok());
  const auto map = grid_of(*raw, {.width = 4, .height = 1, .values = {0, 100, 255, 40}});
  EXPECT_EQ(map.at(0, 0), Cell::kFree);
  EXPECT_EQ(map.at(0, 1), Cell::kOccupied);
  EXPECT_EQ(map.at(0, 2), Cell::kUnknown);
  EXPECT_EQ(map.at(0, 3), Cell::kUnknown);
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

TEST(RosMap, ItsPictureHasTheValuesOfMapSaver) {
  GridMap map{.resolution = 100, .rows = 3, .columns = 2};
  map.cells = {Cell::kFree,     Cell::kUnknown, Cell::kOccupied,
               Cell::kOccupied, Cell::kFree,    Cell::kUnknown};
  const pictures::GreyPicture picture = grey_of(map);
  EXPECT_EQ(picture.width, 2);
  EXPECT_EQ(picture.height, 3);
  EXPECT_EQ(picture.white, 255);
  EXPECT_THAT(picture.values, testing::ElementsAre(254, 205, 0, 0, 254, 205))
      << "beginning in the north";
  EXPECT_EQ(grid_of({.image = "a", .resolution = 0.1}, picture).cells, map.cells);
  EXPECT_TRUE(grey_of({}).values.empty());
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
