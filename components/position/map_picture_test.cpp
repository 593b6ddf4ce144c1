#include "components/position/map_picture.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/localisation/ros_map.h"
#include "components/position/map_file.h"

namespace rack::navigation {
namespace map_picture_test {

using localisation::Cell;
using testing::HasSubstr;

constexpr std::string_view kPng(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x03"
    "\x00\x00\x00\x02\x08\x00\x00\x00\x00\xB8\x1F\x39\xC6\x00\x00\x00\x10\x49\x44\x41"
    "\x54\x78\xDA\x63\xF8\xF7\x8F\x81\xE1\xEC\xBF\x7F\x00\x12\x4F\x04\xC6\x2E\x79\x39"
    "\xE9\x00\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    73);

class MapPictureTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, std::string_view bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string describe(const std::string& image) {
    return write("map.yaml", "image: " + image + "\nresolution: 0.1\norigin: [1, 2, 0]\n");
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("map_picture_test-" + std::to_string(::getpid()));
};

TEST_F(MapPictureTest, MapsArePgmOrPng) {
  write("map.png", kPng);
  write("map.pgm", "P2 3 2 255 254 254 0 205 254 254");
  for (const std::string image : {"map.png", "map.pgm"}) {
    const auto loaded = load_map(describe(image), {});
    ASSERT_TRUE(loaded) << loaded.error().detail();
    const localisation::GridMap& map = loaded->map;
    EXPECT_EQ(map.rows, 2);
    EXPECT_EQ(map.columns, 3);
    EXPECT_EQ(map.at(1, 2), Cell::kOccupied);
    EXPECT_EQ(map.at(0, 0), Cell::kUnknown);
    EXPECT_EQ(map.count(Cell::kFree), 4U);
  }
}

TEST_F(MapPictureTest, AMapComesBack) {
  localisation::GridMap map{.resolution = 100, .origin = {2000, 1000}, .rows = 3, .columns = 2};
  map.cells = {Cell::kFree,     Cell::kUnknown, Cell::kOccupied,
               Cell::kOccupied, Cell::kFree,    Cell::kUnknown};
  const auto picture = localisation::grey_of(map);
  for (const auto& [image, format] : {std::pair("map.pgm", pictures::GreyFormat::kPgm),
                                      std::pair("map.png", pictures::GreyFormat::kPng)}) {
    const auto bytes = pictures::write_grey(picture, format);
    ASSERT_TRUE(bytes) << bytes.error().detail();
    write(image, *bytes);
    const auto back = load_map(describe(image), {});
    ASSERT_TRUE(back) << back.error().detail();
    EXPECT_EQ(back->map.cells, map.cells) << image;
  }
}

TEST_F(MapPictureTest, ErrorsNameThePicture) {
  write("map.jpg", "\xFF\xD8\xFF\xE0 no map");
  const auto map = load_map(describe("map.jpg"), {});
  ASSERT_FALSE(map);
  EXPECT_THAT(map.error().detail(), HasSubstr("map.jpg: neither a PGM"));
}

}  // namespace map_picture_test
}  // namespace rack::navigation
