// A corridor with a door and a bay.
#include "components/path/place_aside.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace rack::path {
namespace place_aside_test {

constexpr AsideSettings kVehicle{.room_to_pass = 300, .room_to_turn = 450, .half_width = 200};

// A corridor of 1.2 m from x = 0 to 9 m, and at x = 4 to 6 m a bay of that depth beside it.
class PlaceAside : public testing::Test {
 protected:
  explicit PlaceAside(double depth = 2000) : space_(*FreeSpace::empty({0, 0}, 9000, 4000, 50)) {
    space_.occupy_area({0, 1200}, {4000, 4000});
    space_.occupy_area({6000, 1200}, {9000, 4000});
    space_.occupy_area({0, 1200 + depth}, {9000, 4000});
    space_.measure();
    for (double x = 300; x < 8800; x += 100) lane_.push_back({x, 600});
  }
  [[nodiscard]] double off_lane(const Place& place) const {
    double least = 1e9;
    for (const Place& on_lane : lane_)
      least = std::min(least, std::hypot(place.x - on_lane.x, place.y - on_lane.y));
    return least;
  }

  FreeSpace space_;
  GridSearch cells_;
  std::vector<Place> lane_;
};

TEST_F(PlaceAside, IsInTheBay) {
  const auto place = place_aside(space_, cells_, kVehicle, {7500, 600}, lane_);
  ASSERT_TRUE(place);
  EXPECT_GE(off_lane(*place), 900 + kVehicle.half_width);
  EXPECT_GE(space_.clearance(*place), kVehicle.room_to_turn);
  EXPECT_GT(place->x, 5000) << "the nearest of these places";
}

TEST_F(PlaceAside, IsNotBehindWhatBlocksThePath) {
  space_.occupy_area({6500, 400}, {6600, 800});
  space_.measure();
  EXPECT_FALSE(place_aside(space_, cells_, kVehicle, {7500, 600}, lane_));
}

TEST_F(PlaceAside, LeavesAPersonWhoIsTooNear) {
  space_.occupy({7500 + 300, 600});
  space_.measure();
  ASSERT_LT(space_.clearance({7500, 600}), kVehicle.room_to_pass);
  EXPECT_TRUE(place_aside(space_, cells_, kVehicle, {7500, 600}, lane_));
}

class NarrowPlaceAside : public PlaceAside {
 protected:
  NarrowPlaceAside() : PlaceAside(600) {}
};

// Where a person can only just pass, it is better than nothing.
TEST_F(NarrowPlaceAside, IsAsFarFromTheLaneAsThereIsRoom) {
  const auto place = place_aside(space_, cells_, kVehicle, {7500, 600}, lane_);
  ASSERT_TRUE(place);
  EXPECT_GE(off_lane(*place), 400 + kVehicle.half_width);
  EXPECT_LT(off_lane(*place), 900 + kVehicle.half_width);
}

TEST_F(NarrowPlaceAside, IsNotInTheLane) {
  space_.occupy_area({0, 1200}, {9000, 4000});
  space_.measure();
  EXPECT_FALSE(place_aside(space_, cells_, kVehicle, {7500, 600}, lane_));
}

TEST_F(PlaceAside, FarAwayIsNowhere) {
  auto wide = FreeSpace::empty({0, 0}, 3 * kAsideMost, 1200, 50);
  wide->occupy_area({0, 0}, {kAsideMost + 3000, 50});
  wide->measure();
  std::vector<Place> lane;
  for (double x = 300; x < kAsideMost + 3000; x += 100) lane.push_back({x, 600});
  EXPECT_FALSE(place_aside(*wide, cells_, kVehicle, {500, 600}, lane));
  EXPECT_TRUE(place_aside(*wide, cells_, kVehicle, {kAsideMost, 600}, lane));
  EXPECT_FALSE(place_aside(*wide, cells_, kVehicle, {-500, 600}, lane)) << "outside of the map";
}

}  // namespace place_aside_test
}  // namespace rack::path
