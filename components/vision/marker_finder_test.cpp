#include "components/vision/marker_finder.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/vision/marker_pose.h"
#include "components/vision/rendered_markers.h"

namespace rack::vision {
namespace marker_finder_test {

constexpr double kLensHeight = 500;

Marker facing_the_robot(double ahead, double right, double turned, double size = 200) {
  return {
      .id = 17, .at = {ahead, right}, .rho = heading(kPi + turned), .height = 700, .size = size};
}

std::vector<Sighting> found_in(const Rendered& picture, const std::set<Family>& families) {
  auto found = MarkerFinder(families).find(picture.view());
  EXPECT_TRUE(found.ok());
  return found ? *found : std::vector<Sighting>{};
}

struct Case {
  double ahead;
  double right;
  double turned;  // degrees
  double size;
  double noise;
  double blur;
  double within;  // mm
};

class SeenMarker : public testing::TestWithParam<Case> {};

TEST_P(SeenMarker, HasItsPose) {
  const Case& is = GetParam();
  const CameraGeometry camera = test_camera();
  Marker marker = facing_the_robot(is.ahead, is.right, radians(is.turned), is.size);
  const auto found =
      found_in(rendered(std::span(&marker, 1), {}, camera, is.noise, is.blur), {Family::kTag36h11});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, 17);
  EXPECT_TRUE(found[0].shows(marker));
  const auto poses = poses_of(found[0], marker.size, camera);
  ASSERT_TRUE(poses);
  EXPECT_LE(poses->at(0).error, poses->at(1).error);
  EXPECT_NEAR(poses->at(0).at.x, is.ahead, is.within);
  EXPECT_NEAR(poses->at(0).at.y, is.right, is.within);
  EXPECT_NEAR(poses->at(0).at.z, -marker.height, is.within);
  // One of the two has its direction.
  const auto off = [&](const MarkerPose& pose) {
    return std::abs(signed_angle(pose.rho - marker.rho));
  };
  EXPECT_LT(std::min(off(poses->at(0)), off(poses->at(1))), radians(4));
}

INSTANTIATE_TEST_SUITE_P(
    All, SeenMarker,
    testing::Values(Case{1000, 0, 0, 200, 0, 0, 10}, Case{1000, 300, 30, 200, 4, 0.5, 15},
                    Case{2000, -500, -45, 200, 4, 0.5, 30}, Case{3000, 800, 20, 200, 4, 0.5, 60},
                    Case{4000, 0, 50, 200, 4, 0.5, 100}, Case{1500, 100, 65, 200, 4, 0.5, 30},
                    Case{800, 0, 10, 160, 8, 1, 15}));

TEST(MarkerFinder, FindsSeveralAndOtherFamilies) {
  const CameraGeometry camera = test_camera();
  std::vector<Marker> markers = {facing_the_robot(1500, -400, 0), facing_the_robot(1500, 0, 0),
                                 facing_the_robot(1500, 400, 0)};
  markers[1].id = 18;
  markers[2].family = Family::kTag16h5;
  const Rendered picture = rendered(markers, {}, camera, 2, 0);
  EXPECT_EQ(found_in(picture, {Family::kTag36h11}).size(), 2U);
  const auto all = found_in(picture, {Family::kTag36h11, Family::kTag16h5, Family::kTag25h9});
  ASSERT_EQ(all.size(), 3U);
  for (const Marker& marker : markers)
    EXPECT_TRUE(std::ranges::any_of(all, [&](const Sighting& s) { return s.shows(marker); }));
}

TEST(MarkerFinder, TooFarIsNotFoundAndNothingElseIs) {
  const CameraGeometry camera = test_camera();
  const Marker marker = facing_the_robot(25000, 0, 0);
  EXPECT_TRUE(
      found_in(rendered(std::span(&marker, 1), {}, camera, 4, 0.5), {Family::kTag36h11}).empty());
  EXPECT_TRUE(found_in(rendered({}, {}, camera, 30, 0), {Family::kTag36h11}).empty());
}

TEST(MarkerFinder, PicturesHaveTheBytesOfTheirSize) {
  MarkerFinder finder({Family::kTag36h11});
  std::vector<std::uint8_t> pixels(99);
  EXPECT_FALSE(finder.find({10, 10, pixels}));
  EXPECT_FALSE(finder.find({-1, 10, pixels}));
  for (const int side : {0, 1, 7, 8, 9}) EXPECT_TRUE(finder.find({side, side, pixels})) << side;
}

TEST(MarkerPose, CornersThatAreNoSquareAreRefused) {
  const CameraGeometry camera = test_camera();
  const ImagePoint one{100, 100};
  EXPECT_FALSE(poses_of({.corners = {one, one, one, one}}, 200, camera));
}

}  // namespace marker_finder_test
}  // namespace rack::vision
