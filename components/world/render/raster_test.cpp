#include "components/world/render/raster.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace rack::world {
namespace raster_test {

constexpr int kSide = 100;
constexpr double kMiddle = 49.5;

const Texture kRed{Colour{200, 0, 0}};
const Texture kBlue{Colour{0, 0, 200}};

// A square ahead of the camera: its focal length is 100, so that 1 mm is a pixel at 100 mm.
std::vector<Corner> square(double ahead, double half) {
  return {{.at = {-half, -half, ahead}, .u = 0, .v = 0},
          {.at = {half, -half, ahead}, .u = 2, .v = 0},
          {.at = {half, half, ahead}, .u = 2, .v = 2},
          {.at = {-half, half, ahead}, .u = 0, .v = 2}};
}

class RasterTest : public testing::Test {
 protected:
  RasterTest() { raster_.clear(); }
  [[nodiscard]] std::uint32_t at(int x, int y) {
    return raster_.pixels()[static_cast<std::size_t>(y * kSide + x)];
  }
  [[nodiscard]] auto count(const Texture& texture) {
    return std::ranges::count(raster_.pixels(), texture.levels()[0].pixels[0]);
  }

  Raster raster_{kSide, kSide, 100, kMiddle, kMiddle};
};

TEST_F(RasterTest, CoversThePixelsWhoseMiddlesAreInside) {
  raster_.draw(square(100, 10.25), {.texture = &kRed});
  EXPECT_EQ(count(kRed), 20 * 20) << "from 39.25 to 59.75";
  EXPECT_EQ(at(40, 40), kRed.levels()[0].pixels[0]);
  EXPECT_NE(at(39, 40), kRed.levels()[0].pixels[0]);
}

TEST_F(RasterTest, TrianglesWithACommonEdgeLeaveNoGap) {
  auto corners = square(100, 30.1);
  corners[1].at[0] += 7;
  corners[3].at[1] -= 5;
  raster_.draw(std::array{corners[0], corners[1], corners[2]}, {.texture = &kRed});
  const auto first = count(kRed);
  raster_.draw(std::array{corners[0], corners[2], corners[3]}, {.texture = &kRed});
  Raster whole(kSide, kSide, 100, kMiddle, kMiddle);
  whole.clear();
  whole.draw(corners, {.texture = &kRed});
  EXPECT_GT(count(kRed), first);
  EXPECT_TRUE(std::ranges::equal(raster_.pixels(), whole.pixels()));
}

TEST_F(RasterTest, TheNearerHidesTheFartherInAnyOrder) {
  for (const bool near_first : {true, false}) {
    raster_.clear();
    if (near_first) raster_.draw(square(100, 10), {.texture = &kRed});
    raster_.draw(square(200, 60), {.texture = &kBlue});
    if (!near_first) raster_.draw(square(100, 10), {.texture = &kRed});
    EXPECT_EQ(count(kRed), 20 * 20);
    EXPECT_EQ(count(kBlue), 60 * 60 - 20 * 20);
  }
  raster_.draw(square(105, 5), {.texture = &kBlue, .nearer = 3});
  EXPECT_EQ(count(kRed), 20 * 20) << "not near enough";
  raster_.draw(square(105, 5), {.texture = &kBlue, .nearer = 10});
  EXPECT_LT(count(kRed), 20 * 20);
}

TEST_F(RasterTest, DrawsFrontsOnly) {
  auto corners = square(100, 10);
  std::ranges::reverse(corners);
  raster_.draw(corners, {.texture = &kRed});
  EXPECT_EQ(count(kRed), 0);
  raster_.draw(corners, {.texture = &kRed, .both_sides = true});
  EXPECT_EQ(count(kRed), 400);
}

TEST_F(RasterTest, NeedsNoClipping) {
  // The ground, from behind the camera to the horizon.
  const std::array ground = {Corner{.at = {-1e6, 50, 1e6}}, Corner{.at = {1e6, 50, 1e6}},
                             Corner{.at = {1e6, 50, -1e6}}, Corner{.at = {-1e6, 50, -1e6}}};
  raster_.draw(ground, {.texture = &kRed});
  EXPECT_EQ(count(kRed), kSide * kSide / 2);
  raster_.clear();
  raster_.draw(square(-100, 10), {.texture = &kRed, .both_sides = true});
  raster_.draw(square(0, 10), {.texture = &kRed, .both_sides = true});
  raster_.draw(square(19, 10), {.texture = &kRed, .both_sides = true});
  EXPECT_EQ(count(kRed), 0) << "behind, at, and too near to the camera";
  raster_.draw(square(21, 10), {.texture = &kRed, .both_sides = true});
  EXPECT_GT(count(kRed), 0);
  const std::array line = {Corner{.at = {0, 0, 100}}, Corner{.at = {10, 0, 100}},
                           Corner{.at = {20, 0, 100}}};
  raster_.clear();
  raster_.draw(line, {.texture = &kRed, .both_sides = true});
  EXPECT_EQ(count(kRed), 0) << "no area";
}

TEST_F(RasterTest, TexturesAreSmoothFromNearAndEvenFromFar) {
  const std::uint32_t white = Colour{200, 200, 200}.packed();
  const std::uint32_t black = Colour{}.packed();
  const Texture chess(2, 2, {white, black, black, white});
  raster_.draw(square(100, 40), {.texture = &chess});
  // The middles of its four pixels are 20 pixels from the middle.
  EXPECT_NEAR(at(30, 30) & 0xFFU, 200, 12);
  EXPECT_NEAR(at(70, 30) & 0xFFU, 0, 12);
  EXPECT_NEAR(at(49, 30) & 0xFFU, 100, 12) << "between them";
  auto far = square(100, 40);
  for (Corner& corner : far) {
    corner.u *= 100;
    corner.v *= 100;
  }
  raster_.clear();
  raster_.draw(far, {.texture = &chess});
  for (const int x : {20, 33, 47, 71}) EXPECT_NEAR(at(x, 55) & 0xFFU, 100, 2) << "their mean";
}

TEST_F(RasterTest, LightIsSpreadBetweenCorners) {
  auto corners = square(100, 40);
  corners[0].light = corners[3].light = 0;
  raster_.draw(corners, {.texture = &kRed});
  EXPECT_NEAR(at(10, 50) >> 16U & 0xFFU, 0, 6);
  EXPECT_NEAR(at(50, 50) >> 16U & 0xFFU, 100, 6);
  EXPECT_NEAR(at(88, 50) >> 16U & 0xFFU, 196, 6);
  raster_.clear();
  raster_.draw(square(100, 40), {.texture = &kRed});
  auto shade = square(100, 10);
  for (Corner& corner : shade) corner.light = 0.5;
  raster_.draw(shade, {.is_shadow = true, .nearer = 1});
  EXPECT_EQ(at(50, 50) >> 16U & 0xFFU, 100U);
  EXPECT_EQ(at(20, 50) >> 16U & 0xFFU, 200U);
}

}  // namespace raster_test
}  // namespace rack::world
