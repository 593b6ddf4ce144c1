// People drawn at known places are found, and are there; furniture is not.
#include "components/vision/people_finder.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "components/pictures/jpeg.h"
#include "components/vision/person_place.h"
#include "components/vision/rendered_people.h"
#include "rack/devices/capture.h"

namespace rack::vision {
namespace people_finder_test {

constexpr double kRangeMax = 10000;

constexpr PersonMeasures kMeasures{.range_max = kRangeMax};

PeopleSearch search_by(const CameraGeometry& camera) {
  return {.smallest = apparent_height(1750, kRangeMax, camera),
          .is_possible = [&camera](const PersonBox& box) {
            return place_of(box, camera, Rendered{}.height, kMeasures).has_value();
          }};
}

std::vector<PersonBox> found_in(const GreyView& picture, const PeopleSearch& search) {
  auto found = PeopleFinder().find(picture, search);
  EXPECT_TRUE(found.ok());
  return found ? *found : std::vector<PersonBox>{};
}

struct Case {
  double lens_height;
  double tilt;  // degrees upwards
  DrawnPerson person;
};

class SeenPerson : public testing::TestWithParam<Case> {};

TEST_P(SeenPerson, IsFoundInItsPlace) {
  const Case& is = GetParam();
  const CameraGeometry camera = test_camera({.z = -is.lens_height, .psi = radians(is.tilt)});
  Rendered picture = rendered_room(camera, 3);
  add_person(picture, is.person, camera);
  add_noise(picture, 4, 0.6, 5);
  const auto found = found_in(picture.view(), search_by(camera));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GE(found[0].score, 0.5);
  const auto place = place_of(found[0], camera, picture.height, kMeasures);
  ASSERT_TRUE(place);
  const double range = std::hypot(is.person.x, is.person.y);
  EXPECT_NEAR(place->range, range, 0.15 * range);
  EXPECT_NEAR(place->range, range, 3 * place->deviation_range);
  EXPECT_NEAR(place->direction, std::atan2(is.person.y, is.person.x), radians(2));
  EXPECT_LT(place->deviation_range, 0.12 * range);
}

INSTANTIATE_TEST_SUITE_P(
    All, SeenPerson,
    testing::Values(Case{500, 0, {.x = 3000}}, Case{500, 0, {.x = 3000, .y = 600, .step = 80}},
                    Case{500, 0, {.x = 4000, .y = -1000, .step = 80, .is_bright = true}},
                    Case{500, 0, {.x = 5000, .y = 1000, .step = 80}},
                    Case{500, 0, {.x = 6000, .y = -1500, .is_bright = true}},
                    Case{500, 0, {.x = 8000, .y = 500, .is_bright = true}},
                    Case{500, 5, {.x = 3000, .y = 300, .is_bright = true}},
                    Case{500, 10, {.x = 4000, .height = 1650, .is_bright = true}},
                    Case{900, 0, {.x = 2500}}, Case{900, 0, {.x = 3500, .is_bright = true}},
                    Case{900, 0, {.x = 5000, .y = -1250, .step = 80}},
                    Case{1400, -10, {.x = 3500, .y = 500}},
                    Case{1400, -10, {.x = 6000, .height = 1850, .step = 80}}));

TEST(PeopleFinder, FindsPeopleBesideEachOther) {
  const CameraGeometry camera = test_camera({.z = -900});
  Rendered picture = rendered_room(camera, 4);
  const std::array people = {DrawnPerson{.x = 4000, .y = -900}, DrawnPerson{.x = 4500, .y = 100},
                             DrawnPerson{.x = 4000, .y = 1000, .is_bright = true}};
  for (const DrawnPerson& person : people) add_person(picture, person, camera);
  add_noise(picture, 4, 0.6, 5);
  const auto found = found_in(picture.view(), search_by(camera));
  EXPECT_EQ(found.size(), people.size());
  for (const DrawnPerson& person : people) {
    const auto at = camera.pixel({person.x, person.y, -900});
    EXPECT_TRUE(std::ranges::any_of(found, [&](const PersonBox& box) {
      return std::abs(box.middle() - at->column) < 10;
    })) << person.y;
  }
}

TEST(PeopleFinder, FurnitureIsNobody) {
  const CameraGeometry camera = test_camera({.z = -600});
  std::size_t placed = 0;
  for (const unsigned seed : {0U, 1U, 2U, 3U, 4U}) {
    Rendered picture = rendered_room(camera, seed);
    EXPECT_TRUE(found_in(picture.view(), search_by(camera)).empty()) << "an empty room";
    add_furniture(picture, camera);
    add_noise(picture, 4, 0.6, seed);
    for (const PersonBox& box : found_in(picture.view(), search_by(camera)))
      placed += place_of(box, camera, picture.height, kMeasures) ? 1 : 0;
  }
  EXPECT_LE(placed, 1U) << "in 5 pictures";
}

// Roads from a small car: nobody is there.
TEST(PeopleFinder, FramesOfACameraHaveNearlyNobody) {
  std::ifstream file(DEVICE_DATA "/camera/donkeycar-20.cap");
  device::CaptureRecord record;
  pictures::Jpeg jpeg;
  std::vector<std::byte> pixels;
  std::size_t pictures = 0;
  std::size_t people = 0;
  for (std::string line; std::getline(file, line);) {
    if (!device::parse_record(line, record).value()) continue;
    const auto size = jpeg.decode(record.bytes, pictures::PixelLayout::kGrey, 1 << 20, pixels);
    ASSERT_TRUE(size);
    const GreyView view{
        .width = static_cast<int>(size->width),
        .height = static_cast<int>(size->height),
        .pixels = {reinterpret_cast<const std::uint8_t*>(pixels.data()), pixels.size()}};
    people += found_in(view, {.smallest = 48}).size();
    ++pictures;
  }
  EXPECT_EQ(pictures, 20U);
  EXPECT_LE(people, 2U) << "0.1 in a picture";
}

TEST(PeopleFinder, ReducedPicturesShowOnlyNearPeople) {
  const CameraGeometry camera = test_camera({.z = -900});
  for (const double ahead : {3000.0, 8000.0}) {
    Rendered picture = rendered_room(camera, 4);
    add_person(picture, {.x = ahead, .is_bright = true}, camera);
    add_noise(picture, 4, 0.6, 5);
    PeopleSearch search = search_by(camera);
    EXPECT_EQ(found_in(picture.view(), search).size(), 1U) << ahead;
    search.side_max = 320;
    EXPECT_EQ(found_in(picture.view(), search).size(), ahead < 5000 ? 1U : 0U) << ahead;
  }
}

TEST(PeopleFinder, ImpossibleWindowsDoNotCount) {
  const CameraGeometry camera = test_camera({.z = -900});
  Rendered picture = rendered_room(camera, 4);
  add_person(picture, {.x = 4000, .is_bright = true}, camera);
  PeopleSearch search = search_by(camera);
  search.is_possible = [](const PersonBox&) { return false; };
  EXPECT_TRUE(found_in(picture.view(), search).empty());
  search.is_possible = nullptr;
  EXPECT_EQ(found_in(picture.view(), search).size(), 1U);
}

TEST(PeopleFinder, HigherScoresFindLess) {
  const CameraGeometry camera = test_camera({.z = -900});
  Rendered picture = rendered_room(camera, 4);
  add_person(picture, {.x = 4000, .is_bright = true}, camera);
  PeopleSearch search = search_by(camera);
  const auto found = found_in(picture.view(), search);
  ASSERT_EQ(found.size(), 1U);
  search.score_min = found[0].score - 1e-3;
  EXPECT_EQ(found_in(picture.view(), search).size(), 1U);
  search.score_min = found[0].score + 1e-3;
  EXPECT_TRUE(found_in(picture.view(), search).empty());
}

TEST(PeopleFinder, PicturesHaveTheBytesOfTheirSize) {
  PeopleFinder finder;
  std::vector<std::uint8_t> pixels(99);
  EXPECT_FALSE(finder.find({10, 10, pixels}, {}));
  EXPECT_FALSE(finder.find({-1, 10, pixels}, {}));
  EXPECT_FALSE(finder.find({1 << 30, 1 << 30, pixels}, {}));
}

TEST(PeopleFinder, PicturesOfAnySizeAreSearched) {
  PeopleFinder finder;
  const std::vector<std::uint8_t> pixels(20000, 90);
  for (const auto& [width, height] : std::initializer_list<std::pair<int, int>>{{0, 0},
                                                                                {1, 1},
                                                                                {1, 20000},
                                                                                {20000, 1},
                                                                                {31, 48},
                                                                                {63, 127},
                                                                                {64, 128},
                                                                                {65, 129},
                                                                                {100, 200}})
    for (const double smallest : {1e-3, 10.0, 96.0, 1e9, 0.0, -1.0, std::nan("")}) {
      const auto found = finder.find({width, height, pixels}, {.smallest = smallest});
      ASSERT_TRUE(found) << width << " x " << height;
      EXPECT_TRUE(found->empty());
    }
}

// --- pure

PersonBox box(double left, double top, double height, double score) {
  return {.left = left, .top = top, .width = height / 2, .height = height, .score = score};
}

TEST(MergedBoxes, OfOnePersonBecomeTheirMean) {
  const auto people = merged({box(100, 100, 200, 1), box(110, 96, 200, 3), box(105, 98, 210, 2)});
  ASSERT_EQ(people.size(), 1U);
  EXPECT_NEAR(people[0].left, (100 + 3 * 110 + 2 * 105) / 6.0, 1e-9);
  EXPECT_NEAR(people[0].height, (200 + 3 * 200 + 2 * 210) / 6.0, 1e-9);
  EXPECT_EQ(people[0].score, 3);
}

TEST(MergedBoxes, APartOfAPersonDoesNotCount) {
  const auto people = merged({box(100, 100, 200, 3), box(125, 150, 100, 1)});
  ASSERT_EQ(people.size(), 1U);
  EXPECT_NEAR(people[0].height, 200, 1e-9);
}

TEST(MergedBoxes, NeighboursStay) {
  // A person is half as wide as its window: 50 pixels.
  EXPECT_EQ(merged({box(100, 100, 200, 2), box(118, 100, 200, 3)}).size(), 1U);
  EXPECT_EQ(merged({box(100, 100, 200, 2), box(122, 100, 200, 3)}).size(), 2U);
  EXPECT_TRUE(merged({}).empty());
}

TEST(MergedBoxes, ScoresThatAreNotPositiveHaveAMean) {
  const auto people = merged({box(100, 100, 200, 0), box(100, 100, 200, -1)});
  ASSERT_EQ(people.size(), 1U);
  EXPECT_NEAR(people[0].left, 100, 1e-9);
}

TEST(ProbabilityOf, GrowsWithTheScore) {
  EXPECT_DOUBLE_EQ(probability_of(0), 0.5);
  EXPECT_NEAR(probability_of(1), 0.88, 0.005);
  EXPECT_LT(probability_of(-1e6), 1e-9);
  EXPECT_LE(probability_of(1e6), 1);
}

}  // namespace people_finder_test
}  // namespace rack::vision
