#include "components/vision/person_place.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/vision/rendered_markers.h"

namespace rack::vision {
namespace person_place_test {

constexpr int kPictureHeight = 480;

// The window around a person of `height` who stands at a place.
PersonBox box_of(const CameraGeometry& camera, const scan3d::Place& feet, double height) {
  const auto head = camera.pixel({feet.x, feet.y, feet.z - height});
  const auto ground = camera.pixel(feet);
  const auto middle = camera.pixel({feet.x, feet.y, feet.z - height / 2});
  const double tall = (ground->row - head->row) / (PersonBox::kFeet - PersonBox::kHead);
  return {.left = middle->column - tall / 4,
          .top = head->row - PersonBox::kHead * tall,
          .width = tall / 2,
          .height = tall,
          .score = 1};
}

TEST(PersonPlace, IsThatOfAPersonOfAverageHeight) {
  for (const Pose& mounting :
       {Pose{.z = -500}, Pose{.x = 200, .y = -100, .z = -900, .rho = radians(20)},
        Pose{.z = -1500, .psi = radians(-12)}, Pose{.x = 100, .z = -400, .psi = radians(10)}}) {
    const CameraGeometry camera = test_camera(mounting);
    for (const double x : {3000.0, 5000.0, 9000.0})
      for (const double y : {-500.0, 0.0, 800.0}) {
        const auto place =
            place_of(box_of(camera, {x, y, 0}, 1750), camera, kPictureHeight, {.range_max = 20000});
        ASSERT_TRUE(place) << x << " " << y;
        EXPECT_NEAR(place->x, x, 25);
        EXPECT_NEAR(place->y, y, 25);
        EXPECT_NEAR(place->height, 1750, 20);
        EXPECT_GT(place->deviation_range, 0.03 * place->range);
        EXPECT_LT(place->deviation_range, 0.1 * place->range);
        EXPECT_GT(place->deviation_across, 10);
        EXPECT_LT(place->deviation_across, 100);
      }
  }
}

TEST(PersonPlace, FeetCorrectTheDistanceOfATallPerson) {
  const CameraGeometry camera = test_camera({.z = -1500});
  const auto place =
      place_of(box_of(camera, {3000, 0, 0}, 1950), camera, kPictureHeight + 1000, {});
  ASSERT_TRUE(place);
  // By the height alone, it would be at 2690.
  EXPECT_GT(place->range, 2850);
  EXPECT_LT(place->range, 3000);
  EXPECT_GT(place->height, 1830);
}

TEST(PersonPlace, WithoutFeetTheHeightRemains) {
  const CameraGeometry camera = test_camera({.z = -1500});
  const PersonBox box = box_of(camera, {3000, 0, 0}, 1950);
  const auto at = [&](int picture_height) { return place_of(box, camera, picture_height, {}); };
  const int feet = static_cast<int>(std::ceil(box.feet()));
  ASSERT_TRUE(at(feet) && at(feet - 1));
  EXPECT_GT(at(feet)->range, 2850);
  EXPECT_NEAR(at(feet - 1)->range, 3000 * 1750 / 1950.0, 5);
  EXPECT_GT(at(feet - 1)->deviation_range, at(feet)->deviation_range);
}

TEST(PersonPlace, WhoFloatsOrIsADollIsNobody) {
  const CameraGeometry camera = test_camera({.z = -900});
  const auto at = [&](double above, double height) {
    return place_of(box_of(camera, {4000, 0, -above}, height), camera, 2 * kPictureHeight, {});
  };
  EXPECT_TRUE(at(0, 1750));
  EXPECT_TRUE(at(0, 1500));
  EXPECT_TRUE(at(0, 2000));
  EXPECT_FALSE(at(0, 900));
  EXPECT_FALSE(at(600, 1750));
  EXPECT_FALSE(at(-900, 1750)) << "below the ground";
}

TEST(PersonPlace, HasLimits) {
  const CameraGeometry camera = test_camera({.z = -900});
  const PersonBox box = box_of(camera, {4000, 0, 0}, 1750);
  EXPECT_TRUE(place_of(box, camera, kPictureHeight, {.range_max = 4010}));
  EXPECT_FALSE(place_of(box, camera, kPictureHeight, {.range_max = 3990}));
  // The feet are not in the picture.
  EXPECT_TRUE(place_of(box_of(camera, {310, 0, 0}, 1750), camera, kPictureHeight, {}));
  EXPECT_FALSE(place_of(box_of(camera, {290, 0, 0}, 1750), camera, kPictureHeight, {}));
}

TEST(PersonPlace, OfNothingIsNone) {
  const CameraGeometry camera = test_camera({.z = -900});
  const double nan = std::nan("");
  const PersonBox good = box_of(camera, {4000, 0, 0}, 1750);
  for (const double wrong : {0.0, -5.0, nan}) {
    PersonBox box = good;
    box.height = wrong;
    EXPECT_FALSE(place_of(box, camera, kPictureHeight, {}));
    box = good;
    box.width = wrong;
    EXPECT_FALSE(place_of(box, camera, kPictureHeight, {}));
    EXPECT_FALSE(place_of(good, camera, kPictureHeight, {.height = wrong}));
  }
  PersonBox box = good;
  box.left = nan;
  EXPECT_FALSE(place_of(box, camera, kPictureHeight, {}));
  const CameraGeometry upwards = test_camera({.z = -900, .psi = radians(89)});
  EXPECT_FALSE(place_of(good, upwards, kPictureHeight, {})) << "a camera that looks at the sky";
}

TEST(ApparentHeight, IsThatInThePicture) {
  const CameraGeometry camera = test_camera();
  EXPECT_NEAR(apparent_height(1750, 5000, camera), 554.3 * 1750 / 5000, 0.01);
}

}  // namespace person_place_test
}  // namespace rack::vision
