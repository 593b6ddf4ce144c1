#include "components/navigation/coordinates.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/angle.h"

namespace rack::navigation {
namespace {

CoordinateSettings settings(PositionReference reference) {
  CoordinateSettings settings;
  settings.reference = reference;
  settings.offset_latitude = 52;
  settings.offset_longitude = 9;
  settings.scale_latitude = 111300;
  settings.scale_longitude = 68400;
  return settings;
}

constexpr PositionWgs84Data place(double latitude, double longitude) {
  return {radians(latitude), radians(longitude), 70000, 1.0F};
}

TEST(Coordinates, DegreesByAScale) {
  Coordinates coordinates(settings(PositionReference::kWgs84), false);
  const auto position = coordinates.from(place(52.001, 8.999));
  ASSERT_TRUE(position);
  EXPECT_EQ(position->pos.x, 111300);
  EXPECT_EQ(position->pos.y, -68400);
  EXPECT_EQ(position->pos.z, -70000);
  EXPECT_EQ(position->pos.rho, 1.0F);
  const auto again = coordinates.to_wgs84(*position);
  EXPECT_NEAR(degrees(again.latitude), 52.001, 1e-9);
  EXPECT_NEAR(degrees(again.longitude), 8.999, 1e-9);
  EXPECT_EQ(again.altitude, 70000);
}

// As the original answers when nobody has set anything.
TEST(Coordinates, WithoutScaleAllIsWhereTheOffsetIs) {
  const PositionData position{.pos = {.x = 1000, .y = 2000, .z = -70000, .rho = 1}};
  const Coordinates nowhere({}, false);
  EXPECT_EQ(nowhere.to_wgs84(position).latitude, 0);
  EXPECT_EQ(nowhere.to_wgs84(position).longitude, 0);
  EXPECT_EQ(nowhere.to_wgs84(position).altitude, 70000);
  EXPECT_EQ(nowhere.to_wgs84(position).heading, 1.0F);
  EXPECT_EQ(nowhere.to_utm(position).zone, 31);
  CoordinateSettings somewhere = settings(PositionReference::kWgs84);
  somewhere.scale_latitude = 0;
  const PositionWgs84Data there = Coordinates(somewhere, false).to_wgs84(position);
  EXPECT_NEAR(degrees(there.latitude), 52, 1e-12);
  EXPECT_NEAR(degrees(there.longitude), 9 + 2.0 / 68400, 1e-12);
}

TEST(Coordinates, TheFirstPlaceBecomesTheOffset) {
  Coordinates coordinates(settings(PositionReference::kUtm), true);
  const auto first = coordinates.from(PositionUtmData{5800123456, 548049999, 32, 18, 0, 0});
  ASSERT_TRUE(first);
  EXPECT_EQ(coordinates.settings().offset_northing, 5800100);
  EXPECT_EQ(coordinates.settings().offset_easting, 548000);
  EXPECT_EQ(first->pos.x, 23456);
  EXPECT_EQ(first->pos.y, 49999);
  const auto second = coordinates.from(PositionUtmData{5800200000, 548000000, 32, 18, 0, 0});
  EXPECT_EQ(second->pos.x, 100000) << "the offset stays";
  const auto again = coordinates.to_utm(*first);
  EXPECT_EQ(again.northing, 5800123456);
  EXPECT_EQ(again.zone, 32);
}

TEST(Coordinates, TheFirstPlaceBringsItsZoneAndBand) {
  Coordinates coordinates(settings(PositionReference::kUtm), true);
  ASSERT_TRUE(coordinates.from(place(-33, 151)));
  EXPECT_EQ(coordinates.settings().utm_zone, 56);
  EXPECT_EQ(coordinates.settings().utm_band, 7) << "H";
  ASSERT_TRUE(coordinates.from(PositionUtmData{5800200000, 548000000, 32, 18, 0, 0}));
  EXPECT_EQ(coordinates.settings().utm_zone, 56) << "the first one counts";
  Coordinates fixed(settings(PositionReference::kUtm), false);
  ASSERT_TRUE(fixed.from(place(-33, 151)));
  EXPECT_EQ(fixed.settings().utm_zone, 32);
}

TEST(Coordinates, AllSpeakOfTheSamePlace) {
  for (const auto reference :
       {PositionReference::kWgs84, PositionReference::kGaussKrueger, PositionReference::kUtm}) {
    Coordinates coordinates(settings(reference), reference != PositionReference::kWgs84);
    const auto position = coordinates.from(place(52.4, 9.7));
    ASSERT_TRUE(position);
    const auto by_gk = coordinates.from(coordinates.to_gk(*position));
    const auto by_utm = coordinates.from(coordinates.to_utm(*position));
    EXPECT_NEAR(by_gk->pos.x, position->pos.x, 2);
    EXPECT_NEAR(by_gk->pos.y, position->pos.y, 2);
    EXPECT_NEAR(by_utm->pos.x, position->pos.x, 2);
    EXPECT_NEAR(by_utm->pos.y, position->pos.y, 2);
  }
}

TEST(Coordinates, RefusesWhatIsNoPlace) {
  Coordinates coordinates(settings(PositionReference::kUtm), true);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(coordinates.from(PositionWgs84Data{kNaN, 0, 0, 0}));
  EXPECT_FALSE(coordinates.from(PositionWgs84Data{2, 0, 0, 0}));
  EXPECT_FALSE(coordinates.from(PositionGkData{kNaN, 0, 0, 0}));
  EXPECT_FALSE(coordinates.from(PositionUtmData{0, 0, 61, 18, 0, 0}));
  EXPECT_FALSE(coordinates.from(PositionUtmData{0, 0, 1, 24, 0, 0}));
}

}  // namespace
}  // namespace rack::navigation
