#include "components/navigation/projection.h"

#include <gtest/gtest.h>

#include "components/geometry/angle.h"

namespace rack::navigation {
namespace {

constexpr double kMillimetre = 1.6e-10;  // rad on the ground

TEST(Projection, KnownLengthsOfTheMeridian) {
  const Grid wgs84{kWgs84, 1, 0};
  EXPECT_NEAR(project({radians(45), 0}, wgs84).north, 4984944.378, 0.002);
  EXPECT_NEAR(project({radians(90), 0}, wgs84).north, 10001965.729, 0.002);
  const Grid bessel{kBessel, 1, 0};
  EXPECT_NEAR(project({radians(90), 0}, bessel).north, 10000855.764, 0.005);
}

TEST(Projection, ThereAndBack) {
  for (double latitude : {-70.0, -10.0, 0.0, 0.1, 47.0, 55.0, 83.0}) {
    for (double longitude : {5.0, 9.0, 12.5}) {
      const Grid grid{kWgs84, 0.9996, radians(9)};
      const Geodetic at{radians(latitude), radians(longitude)};
      const Geodetic again = unproject(project(at, grid), grid);
      EXPECT_NEAR(again.latitude, at.latitude, kMillimetre);
      EXPECT_NEAR(again.longitude, at.longitude, kMillimetre / std::cos(at.latitude));
    }
  }
}

TEST(Projection, BesselLiesAHundredMetresAway) {
  const Geodetic at{radians(52.4), radians(9.7)};
  const Geodetic bessel = wgs84_to_bessel(at);
  const double north = (bessel.latitude - at.latitude) * 6.37e6;
  const double east = (bessel.longitude - at.longitude) * 6.37e6 * std::cos(at.latitude);
  EXPECT_GT(std::hypot(north, east), 50);
  EXPECT_LT(std::hypot(north, east), 250);
  const Geodetic again = bessel_to_wgs84(bessel);
  EXPECT_NEAR(again.latitude, at.latitude, 10 * kMillimetre);
  EXPECT_NEAR(again.longitude, at.longitude, 10 * kMillimetre);
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

TEST(GaussKrueger, ThereAndBack) {
  const PositionWgs84Data from{
      .latitude = radians(52.4), .longitude = radians(9.7), .altitude = 5, .heading = 1};
  const PositionGkData gk = to_gk(from);
  EXPECT_NEAR(gk.easting, 3547700e3, 500e3) << "zone 3, some 48 km east of 9 degrees";
  EXPECT_NEAR(gk.northing, 5807700e3, 2000e3);
  const PositionWgs84Data again = to_wgs84(gk);
  EXPECT_NEAR(again.latitude, from.latitude, 10 * kMillimetre);
  EXPECT_NEAR(again.longitude, from.longitude, 10 * kMillimetre);
  EXPECT_EQ(again.altitude, 5);
}

}  // namespace
}  // namespace rack::navigation
