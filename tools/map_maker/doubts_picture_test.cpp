// The picture of a map that contradicts itself.
#include "tools/map_maker/doubts_picture.h"

#include <array>

#include <gtest/gtest.h>

namespace rack::map_maker {

namespace doubts_picture_test {

using localisation::Cell;

mapping::MadeMap made(std::int32_t rows, std::int32_t columns) {
  mapping::MadeMap made;
  made.map = {.resolution = 50, .origin = {-1000, 0}, .rows = rows, .columns = columns};
  made.map.cells.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns),
                        Cell::kFree);
  return made;
}

std::array<int, 3> colour(const ColourPicture& picture, std::int32_t line, std::int32_t column) {
  const auto at = 3 * static_cast<std::size_t>(line * picture.width + column);
  return {static_cast<int>(picture.rgb[at]), static_cast<int>(picture.rgb[at + 1]),
          static_cast<int>(picture.rgb[at + 2])};
}

TEST(DoubtsPicture, ShowsWallsTheDriveAndWhatIsSeenThrough) {
  auto map = made(10, 20);
  map.map.cells[0] = Cell::kOccupied;
  map.map.cells[1] = Cell::kUnknown;
  map.poses.push_back({.x = -1000 + 25, .y = 19 * 50 + 25});
  map.doubts.walls.push_back({-1000 + 9 * 50 + 25, 10 * 50 + 25});
  map.doubts.walls.push_back({1e9, 0});  // not on the map
  const auto picture = draw_doubts(map);
  ASSERT_EQ(picture.width, 20);
  ASSERT_EQ(picture.height, 10);
  EXPECT_EQ(colour(picture, 9, 0), (std::array{0, 0, 0})) << "the south is below";
  EXPECT_EQ(colour(picture, 9, 1), (std::array{205, 205, 205}));
  EXPECT_EQ(colour(picture, 5, 5), (std::array{254, 254, 254}));
  EXPECT_GT(colour(picture, 9, 19)[2], colour(picture, 9, 19)[0]) << "blue";
  EXPECT_GT(colour(picture, 0, 10)[0], 2 * colour(picture, 0, 10)[2]) << "red";
}

TEST(DoubtsPicture, ReducesLargeMapsAndKeepsTheirWalls) {
  auto map = made(3, 4001);
  map.map.cells[4000] = Cell::kOccupied;
  const auto picture = draw_doubts(map);
  EXPECT_EQ(picture.width, 2001);
  EXPECT_EQ(picture.height, 2);
  EXPECT_EQ(colour(picture, 1, 2000), (std::array{0, 0, 0}));
  EXPECT_EQ(draw_doubts(made(3, 4000)).width, 4000);
}

}  // namespace doubts_picture_test

}  // namespace rack::map_maker
