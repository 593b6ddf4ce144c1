#include "components/localisation/floor_plan.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/floor_map.h"
#include "components/localisation/line_map.h"

namespace rack::localisation {

namespace floor_plan_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Files by their paths; their pictures have a room of 3 x 4 cells within walls.
const std::map<std::string, std::string> kFiles = {
    {"m/room.yaml", "image: room.pgm\nresolution: 0.1\norigin: [-1, 2, 0]\n"},
    {"m/ROOM.YML", "image: /pictures/room.pgm\nresolution: 0.1\n"},
    {"m/room.pgm", "P5 6 5"},
    {"/pictures/room.pgm", "P5 6 5"},
    {"m/none.yaml", "image: none.pgm\nresolution: 0.1\n"},
    {"m/damaged.yaml", "image: damaged.pgm\nresolution: 0.1\n"},
    {"m/damaged.pgm", "P5"},
    {"m/wrong.yaml", "resolution: 0.1\n"},
    {"m/white.yaml", "image: white.pgm\nresolution: 0.1\n"},
    {"m/white.pgm", "white"},
    {"m/room.dxf", "0\nLINE\n10\n1\n20\n2\n11\n3\n21\n4\n0\nLINE\n10\n1\n20\n2\n0\nEOF\n"},
    {"m/wrong.dxf", "image: room.pgm\n"},
};

MapSources sources() {
  return {.read_file = [](const std::string& path) -> tims::Result<std::string> {
            const auto found = kFiles.find(path);
            if (found != kFiles.end()) return found->second;
            return tims::Error(tims::Errc::kSystem, path + ": No such file or directory");
          },
          .decode = [](std::string_view bytes) -> tims::Result<pictures::GreyPicture> {
            if (bytes == "P5") return tims::Error(tims::Errc::kMalformed, "no valid size");
            pictures::GreyPicture picture{.width = 6, .height = 5};
            for (int i = 0; i < 30; ++i) {
              const bool is_wall = i < 6 || i >= 24 || i % 6 == 0 || i % 6 == 5;
              picture.values.push_back(is_wall && bytes != "white" ? 0 : 254);
            }
            return picture;
          }};
}

tims::Result<FloorPlan> read(const std::string& path, const PlanPlacement& placement = {}) {
  return read_floor_plan(path, placement, sources());
}

std::string error_of(const std::string& path) {
  const auto plan = read(path);
  return plan ? "it was read" : plan.error().detail();
}

TEST(FloorPlan, OfRosIsCellsAndLines) {
  const auto plan = read("m/room.yaml", {.scale = 1, .offset_x = 9, .offset_y = 9});
  ASSERT_TRUE(plan) << plan.error().detail();
  const auto cells = cells_of(*plan, 50);
  ASSERT_TRUE(cells);
  EXPECT_DOUBLE_EQ(cells->resolution, 100) << "its own";
  EXPECT_EQ(cells->count(Cell::kFree), 12U);
  const auto lines = lines_of(*plan);
  ASSERT_TRUE(lines);
  EXPECT_THAT(lines->drawing.remarks, IsEmpty());
  EXPECT_EQ(lines->drawing.lines.size(), 8U);
  // The room begins at x = 2 m + a cell, y = -1 m + a cell.
  const FloorMap walls(*lines);
  EXPECT_DOUBLE_EQ(walls.clearance({2250, -700}), 150);
  EXPECT_DOUBLE_EQ(walls.clearance({2000, -1000}), 0);
  LineMap editable(*lines);
  EXPECT_EQ(editable.size(), 8U);
}

TEST(FloorPlan, OfADrawingIsCellsAndLines) {
  const auto plan = read("m/room.dxf", {.scale = 1000, .offset_x = 1, .offset_y = 0});
  ASSERT_TRUE(plan) << plan.error().detail();
  const auto cells = cells_of(*plan, 50);
  ASSERT_TRUE(cells);
  EXPECT_DOUBLE_EQ(cells->resolution, 50);
  const auto lines = lines_of(*plan);
  ASSERT_TRUE(lines);
  EXPECT_THAT(lines->drawing.remarks, ElementsAre("m/room.dxf, line 11: LINE without an end"));
  EXPECT_DOUBLE_EQ(FloorMap(*lines).clearance({1000, 1000}), 0);
}

TEST(FloorPlan, ItsImageIsBesideItOrAnywhere) {
  EXPECT_EQ(error_of("m/ROOM.YML"), "it was read");
  EXPECT_EQ(error_of("m/none.yaml"),
            "m/none.yaml: its image: m/none.pgm: No such file or directory");
}

TEST(FloorPlan, ErrorsNameTheFile) {
  EXPECT_EQ(error_of("nowhere.dxf"), "nowhere.dxf: No such file or directory");
  EXPECT_EQ(error_of("m/damaged.yaml"), "m/damaged.pgm: no valid size");
  EXPECT_EQ(error_of("m/wrong.yaml"), "m/wrong.yaml: no `image: FILE`");
  EXPECT_THAT(error_of("m/wrong.dxf"), HasSubstr("m/wrong.dxf: line 1: no group code"));
  EXPECT_EQ(error_of("m/room.pgm"),
            "m/room.pgm: a picture without scale: use the .yaml file that describes it");
  const auto white = read("m/white.yaml");
  ASSERT_TRUE(white);
  EXPECT_EQ(lines_of(*white).error().detail(), "m/white.yaml: the map has no occupied cells");
}

}  // namespace floor_plan_test

}  // namespace rack::localisation
