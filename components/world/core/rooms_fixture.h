// For tests of the world: rooms, a robot, and helpers.
#pragma once

#include <chrono>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "components/world/core/world.h"

namespace rack::world {

// Two rooms with a door of 900 mm between them.
inline std::vector<WallDescription> two_rooms() {
  const auto wall = [](double x1, double y1, double x2, double y2) {
    return WallDescription{.from = {x1, y1}, .to = {x2, y2}};
  };
  return {wall(0, 0, 0, 10000), wall(0, 10000, 6000, 10000), wall(6000, 10000, 6000, 0),
          wall(6000, 0, 0, 0),  wall(0, 5000, 2000, 5000),   wall(2900, 5000, 6000, 5000)};
}
inline const std::vector<ObstacleDescription> kTable = {{.at = {3000, 7500}, .length = 1500}};
inline constexpr Area kRooms{{0, 0}, {6000, 10000}};

inline constexpr tims::Time kBegin{std::chrono::hours(1)};

inline tims::Duration seconds(double count) {
  return std::chrono::duration_cast<tims::Duration>(std::chrono::duration<double>(count));
}

// A robot of 500 mm by 400 mm in the middle of the first room, with a scanner at 300 mm.
inline RobotDescription room_robot() {
  RobotDescription robot;
  robot.name = "one";
  robot.start = {.x = 3000, .y = 2500};
  robot.front = robot.back = 250;
  robot.left = robot.right = 200;
  robot.sensors = {{.name = "laser", .mount = {.x = 100, .z = -300}, .max_range = 30000}};
  return robot;
}

inline WorldDescription rooms_world(std::size_t people = 0) {
  WorldDescription world;
  world.ground = kRooms;
  world.walls = two_rooms();
  world.obstacles = kTable;
  world.people.count = people;
  world.robots = {room_robot()};
  return world;
}

inline World made(WorldDescription description) {
  auto world = World::make(std::move(description), kBegin);
  EXPECT_TRUE(world.ok()) << world.error().detail();
  return std::move(*world);
}

}  // namespace rack::world
