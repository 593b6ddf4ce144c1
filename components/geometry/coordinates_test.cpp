#include "components/geometry/coordinates.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::navigation {

namespace coordinates_test {

constexpr double kMillimetre = 1.6e-10;  // rad on the ground

TEST(Projection, KnownLengthsOfTheMeridian) {
  const Grid wgs84{kEarth, 1, 0};
  EXPECT_NEAR(project({radians(45), 0}, wgs84).north, 4984944.378, 0.002);
  EXPECT_NEAR(project({radians(90), 0}, wgs84).north, 10001965.729, 0.002);
  const Grid bessel{kBessel, 1, 0};
  EXPECT_NEAR(project({radians(90), 0}, bessel).north, 10000855.764, 0.005);
}

TEST(Projection, ThereAndBack) {
  for (double latitude : {-70.0, -10.0, 0.0, 0.1, 47.0, 55.0, 83.0}) {
    for (double longitude : {5.0, 9.0, 12.5}) {
      const Grid grid{kEarth, 0.9996, radians(9)};
      const Geodetic at{radians(latitude), radians(longitude)};
      const Geodetic again = unproject(project(at, grid), grid);
      EXPECT_NEAR(again.latitude, at.latitude, kMillimetre);
      EXPECT_NEAR(again.longitude, at.longitude, kMillimetre / std::cos(at.latitude));
    }
  }
}

// WGS84 in degrees, and where EPSG:1777 puts it on Bessel's ellipsoid: it is good to some metres,
// and so is the transformation of the original.
struct Known {
  const char* name;
  double latitude, longitude;
  double bessel_latitude, bessel_longitude, bessel_height;
};
constexpr std::array<Known, 4> kKnown = {{
    {"Hannover", 52.38, 9.72, 52.38141664665, 9.72117216108, -43.15},
    {"Munich", 48.137, 11.575, 48.13792132330, 11.57638809391, -51.97},
    {"Kiel", 54.323, 10.123, 54.32463742468, 10.12426206085, -37.27},
    {"Aachen", 50.776, 6.084, 50.77724063592, 6.08461115910, -47.64},
}};

TEST(Projection, BesselLiesWhereItIsKnownToLie) {
  for (const Known& known : kKnown) {
    const Geodetic at{radians(known.latitude), radians(known.longitude), 0};
    const Geodetic bessel = wgs84_to_bessel(at);
    const double north = (bessel.latitude - radians(known.bessel_latitude)) * 6.37e6;
    const double east =
        (bessel.longitude - radians(known.bessel_longitude)) * 6.37e6 * std::cos(at.latitude);
    EXPECT_LT(std::hypot(north, east), 5) << known.name;
    EXPECT_NEAR(bessel.height, known.bessel_height, 1) << known.name;
    const Geodetic again = bessel_to_wgs84(bessel);
    EXPECT_NEAR(again.latitude, at.latitude, 10 * kMillimetre);
    EXPECT_NEAR(again.longitude, at.longitude, 10 * kMillimetre);
    EXPECT_NEAR(again.height, 0, 0.01);
  }
}

TEST(Utm, ZonesBandsAndNumbers) {
  const auto utm = [](double latitude, double longitude) {
    return to_utm({.latitude = radians(latitude), .longitude = radians(longitude)});
  };
  EXPECT_EQ(utm(45, 9).zone, 32);
  EXPECT_EQ(utm(45, 9).easting, 500000000);
  EXPECT_NEAR(static_cast<double>(utm(45, 9).northing), 4982950400, 5);
  EXPECT_EQ(utm(52.4, 9.7).band, 18) << "U";
  EXPECT_EQ(utm(0, -179.9).zone, 1);
  EXPECT_EQ(utm(0, 179.9).zone, 60);
  EXPECT_EQ(utm(0, 0).band, 12) << "N";
  EXPECT_EQ(utm(-0.1, 0).band, 11) << "M";
  EXPECT_NEAR(static_cast<double>(utm(-45, 9).northing), 1e10 - 4982950400, 5);
  EXPECT_EQ(utm(84, 0).band, 21) << "X";
}

TEST(Utm, ThereAndBack) {
  const PositionWgs84Data from{
      .latitude = radians(-33), .longitude = radians(151), .altitude = 5, .heading = 1};
  const PositionWgs84Data again = to_wgs84(to_utm(from));
  EXPECT_NEAR(again.latitude, from.latitude, kMillimetre);
  EXPECT_NEAR(again.longitude, from.longitude, kMillimetre);
  EXPECT_EQ(again.altitude, 5);
  EXPECT_EQ(again.heading, 1.0F);
}

// Northing and easting from another program's series, by the original's own numbers.
TEST(GaussKrueger, KnownPlaces) {
  const auto check = [](double latitude, double longitude, double northing, double easting,
                        i32 altitude) {
    const PositionWgs84Data from{.latitude = radians(latitude),
                                 .longitude = radians(longitude),
                                 .altitude = 100000,
                                 .heading = 1};
    const PositionGkData gk = to_gk(from);
    EXPECT_NEAR(gk.northing / 1000, northing, 0.01);
    EXPECT_NEAR(gk.easting / 1000, easting, 0.01);
    EXPECT_NEAR(gk.altitude.raw(), altitude, 10);
    EXPECT_EQ(gk.heading, 1.0F);
    const PositionWgs84Data again = to_wgs84(gk);
    EXPECT_NEAR(again.latitude, from.latitude, 10 * kMillimetre);
    EXPECT_NEAR(again.longitude, from.longitude, 10 * kMillimetre);
    EXPECT_NEAR(again.altitude.raw(), 100000, 10);
    EXPECT_EQ(again.heading, 1.0F);
  };
  check(52.38, 9.72, 5805430.028, 3549102.909, 57550);
  check(48.137, 11.575, 5333305.309, 4468474.628, 47804);
  check(54.323, 10.123, 6022009.016, 3573143.233, 63691);
  check(50.776, 6.084, 5626732.105, 2505969.236, 53151);
}

}  // namespace coordinates_test

namespace coordinates_test {

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

}  // namespace coordinates_test

}  // namespace rack::navigation
