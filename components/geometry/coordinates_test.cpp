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

PositionWgs84Data at(double latitude, double longitude) {
  return {.latitude = radians(latitude), .longitude = radians(longitude)};
}

// What this project's own series gave before GeographicLib: they were good to a millimetre.
struct Before {
  double latitude, longitude;
  i32 zone, band;
  i64 utm_northing, utm_easting;   // mm
  double gk_northing, gk_easting;  // m
  i32 gk_altitude;                 // mm
};
constexpr std::array<Before, 12> kBefore = {{
    {52.3800, 9.7200, 32, 18, 5803548173, 549008447, 5805430.032, 3549102.916, -42456},
    {-33.8568, 151.2153, 56, 7, 6252288753, 334900570, -3748096.479, 50612869.085, 1275413},
    {37.5400, -122.0600, 10, 16, 4155194154, 583043297, 4155866.012, -40417363.324, 714829},
    {0.0010, -0.0010, 30, 12, 110683, 833867128, -288.088, 499852.418, 85939},
    {-54.8000, -68.3000, 19, 5, 3927239381, 545000053, -6074797.513, -22455558.648, 874355},
    {64.1500, -21.9500, 27, 20, 7114074067, 453784008, 7116428.541, -6546462.931, 41024},
    {1.2900, 103.8500, 48, 12, 142612911, 372057368, 142211.504, 35372659.215, 730836},
    {-79.9000, 179.9000, 60, 2, 1128161373, 556752128, -8872469.730, 60498175.888, 1106907},
    {83.9000, -179.9000, 1, 21, 9317795753, 465609169, 9318993.494, -59498772.308, 280414},
    {71.9500, 8.5000, 32, 20, 7983427172, 482708679, 7986159.882, 3482770.633, 55504},
    {35.6800, 139.6900, 54, 16, 3949247236, 381454346, 3949783.723, 47381872.610, 746974},
    {-0.0001, 29.9900, 35, 11, 9999988932, 832864275, -432.239, 10499157.105, 124454},
}};

TEST(Projection, IsWhereItWasBefore) {
  for (const Before& was : kBefore) {
    const std::string place = std::to_string(was.latitude) + " " + std::to_string(was.longitude);
    const auto utm = to_utm(at(was.latitude, was.longitude));
    ASSERT_TRUE(utm) << place;
    EXPECT_EQ(utm->zone, was.zone) << place;
    EXPECT_EQ(utm->band, was.band) << place;
    EXPECT_NEAR(static_cast<double>(utm->northing - was.utm_northing), 0, 2) << place;
    EXPECT_NEAR(static_cast<double>(utm->easting - was.utm_easting), 0, 2) << place;
    const auto gk = to_gk(at(was.latitude, was.longitude));
    ASSERT_TRUE(gk) << place;
    EXPECT_NEAR(gk->northing.si(), was.gk_northing, 0.002) << place;
    EXPECT_NEAR(gk->easting.si(), was.gk_easting, 0.002) << place;
    EXPECT_NEAR(gk->altitude.raw(), was.gk_altitude, 10) << place;
  }
}

TEST(Utm, ZonesBandsAndNumbers) {
  const auto utm = [](double latitude, double longitude) {
    return to_utm(at(latitude, longitude)).value();
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

TEST(Utm, TheMeridianOf180DegreesIsInZone1) {
  for (const double longitude : {180.0, -180.0}) {
    const auto utm = to_utm(at(10, longitude));
    ASSERT_TRUE(utm);
    EXPECT_EQ(utm->zone, 1);
    const auto again = to_wgs84(*utm);
    ASSERT_TRUE(again);
    EXPECT_NEAR(std::abs(degrees(again->longitude)), 180, 1e-7);
  }
  EXPECT_EQ(to_utm(at(10, 179.999999)).value().zone, 60);
  EXPECT_EQ(to_utm(at(10, -179.999999)).value().zone, 1);
  EXPECT_EQ(to_utm(at(10, 181)).value().zone, 1) << "longitudes of up to a turn";
  EXPECT_EQ(to_utm(at(10, 359)).value().zone, 30);
  EXPECT_EQ(to_utm(at(10, -359)).value().zone, 31);
}

TEST(Utm, NorwayAndSvalbardHaveZonesOfTheirOwn) {
  const auto zone = [](double latitude, double longitude) {
    return to_utm(at(latitude, longitude)).value().zone;
  };
  EXPECT_EQ(zone(60.39, 5.32), 32) << "Bergen";
  EXPECT_EQ(zone(60.39, 2.99), 31);
  EXPECT_EQ(zone(55.99, 5.32), 31);
  EXPECT_EQ(zone(64, 5.32), 31);
  EXPECT_EQ(zone(78.2, 15.6), 33) << "Longyearbyen";
  EXPECT_EQ(zone(72, 8.99), 31);
  EXPECT_EQ(zone(72, 9), 33);
  EXPECT_EQ(zone(80, 21), 35);
  EXPECT_EQ(zone(80, 33), 37);
  EXPECT_EQ(zone(80, 42), 38);
  EXPECT_EQ(zone(71.99, 9), 32);
  const auto again = to_wgs84(to_utm(at(60.39, 5.32)).value());
  ASSERT_TRUE(again);
  EXPECT_NEAR(degrees(again->latitude), 60.39, 1e-8);
  EXPECT_NEAR(degrees(again->longitude), 5.32, 1e-8);
  EXPECT_NEAR(degrees(utm_grid({radians(60.39), radians(5.32), 0}).meridian), 9, 1e-12);
}

TEST(Utm, EndsBeforeThePoles) {
  EXPECT_TRUE(to_utm(at(84, 20)));
  EXPECT_TRUE(to_utm(at(-80, 20)));
  EXPECT_EQ(to_utm(at(-80, 20)).value().band, 2) << "C";
  for (const double latitude : {84.000001, 90.0, -80.000001, -90.0}) {
    const auto utm = to_utm(at(latitude, 20));
    ASSERT_FALSE(utm) << latitude;
    EXPECT_NE(utm.error().detail().find("84 degrees north"), std::string::npos);
  }
}

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(Utm, RefusesWhatIsNoPlace) {
  for (const double wrong : {kNotANumber, kInfinite, -kInfinite}) {
    EXPECT_FALSE(to_utm({.latitude = wrong}));
    EXPECT_FALSE(to_utm({.longitude = wrong}));
  }
  EXPECT_FALSE(to_utm({.latitude = 1, .longitude = 6.3}));
}

TEST(Utm, ZonesAndBandsThatThereAreNotAreRefused) {
  PositionUtmData utm = to_utm(at(52, 9)).value();
  const auto reason = [&](i32 zone, i32 band) {
    utm.zone = zone;
    utm.band = band;
    const auto place = to_wgs84(utm);
    return place ? std::string() : place.error().detail();
  };
  EXPECT_EQ(reason(1, 18), "");
  EXPECT_EQ(reason(60, 18), "");
  EXPECT_NE(reason(0, 18).find("UTM zones are 1 to 60, not 0"), std::string::npos);
  EXPECT_NE(reason(61, 18).find("not 61"), std::string::npos);
  EXPECT_EQ(reason(32, 2), "");
  EXPECT_EQ(reason(32, 21), "");
  EXPECT_NE(reason(32, 1).find("UTM bands are 2 (C) to 21 (X), not 1"), std::string::npos);
  EXPECT_NE(reason(32, 22).find("not 22"), std::string::npos);
}

TEST(Utm, NumbersOutsideOfAZoneAreRefused) {
  const auto is_place = [](i64 northing, i64 easting, i32 band) {
    return to_wgs84(PositionUtmData{northing, easting, 32, band, 0, 0}).ok();
  };
  EXPECT_TRUE(is_place(5800000000, 0, 18));
  EXPECT_TRUE(is_place(5800000000, 1000000000, 18));
  EXPECT_FALSE(is_place(5800000000, -1, 18));
  EXPECT_FALSE(is_place(5800000000, 1000000001, 18));
  EXPECT_TRUE(is_place(9600000000, 500000000, 21));
  EXPECT_FALSE(is_place(9600000001, 500000000, 21));
  EXPECT_TRUE(is_place(900000000, 500000000, 2));
  EXPECT_FALSE(is_place(899999999, 500000000, 2));
  EXPECT_FALSE(is_place(std::numeric_limits<i64>::max(), 500000000, 18));
  EXPECT_FALSE(is_place(5800000000, std::numeric_limits<i64>::min(), 18));
}

TEST(Utm, ThereAndBack) {
  const PositionWgs84Data from{
      .latitude = radians(-33), .longitude = radians(151), .altitude = 5, .heading = 1};
  const PositionWgs84Data again = to_wgs84(to_utm(from).value()).value();
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
    const PositionGkData gk = to_gk(from).value();
    EXPECT_NEAR(gk.northing / 1000, northing, 0.01);
    EXPECT_NEAR(gk.easting / 1000, easting, 0.01);
    EXPECT_NEAR(gk.altitude.raw(), altitude, 10);
    EXPECT_EQ(gk.heading, 1.0F);
    const PositionWgs84Data again = to_wgs84(gk).value();
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

TEST(GaussKrueger, PolesAndTheMeridianOf180DegreesArePlaces) {
  for (const auto& [latitude, longitude] :
       {std::pair{90.0, 0.0}, {-90.0, 10.0}, {52.0, 180.0}, {52.0, -180.0}, {0.0, 0.0}}) {
    const auto gk = to_gk(at(latitude, longitude));
    ASSERT_TRUE(gk) << latitude;
    const auto again = to_wgs84(*gk);
    ASSERT_TRUE(again) << latitude;
    EXPECT_NEAR(degrees(again->latitude), latitude, 1e-6);
    if (std::abs(latitude) == 90) continue;  // any longitude is correct there
    EXPECT_NEAR(std::remainder(degrees(again->longitude) - longitude, 360), 0, 1e-6);
  }
}

TEST(GaussKrueger, RefusesWhatIsNoPlace) {
  const auto is_place = [](double northing, double easting) {
    return to_wgs84(PositionGkData{northing * 1000, easting * 1000, 0, 0}).ok();
  };
  for (const double wrong : {kNotANumber, kInfinite, -kInfinite, 1e300, -1e300}) {
    EXPECT_FALSE(is_place(wrong, 3500000));
    EXPECT_FALSE(is_place(5800000, wrong));
  }
  EXPECT_TRUE(is_place(10002000, 3500000));
  EXPECT_FALSE(is_place(10002001, 3500000));
  EXPECT_FALSE(is_place(-10002001, 3500000));
  EXPECT_TRUE(is_place(5800000, 119999999));
  EXPECT_FALSE(is_place(5800000, 120000000));
  EXPECT_TRUE(is_place(5800000, -60000000));
  EXPECT_FALSE(is_place(5800000, -60000001));
  EXPECT_FALSE(to_gk({.latitude = kNotANumber}));
  EXPECT_FALSE(to_gk({.latitude = 1.58}));
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
  const auto again = coordinates.to_wgs84(*position).value();
  EXPECT_NEAR(degrees(again.latitude), 52.001, 1e-9);
  EXPECT_NEAR(degrees(again.longitude), 8.999, 1e-9);
  EXPECT_EQ(again.altitude, 70000);
}

// As the original answers when nobody has set anything.
TEST(Coordinates, WithoutScaleAllIsWhereTheOffsetIs) {
  const PositionData position{.pos = {.x = 1000, .y = 2000, .z = -70000, .rho = 1}};
  const Coordinates nowhere({}, false);
  EXPECT_EQ(nowhere.to_wgs84(position)->latitude, 0);
  EXPECT_EQ(nowhere.to_wgs84(position)->longitude, 0);
  EXPECT_EQ(nowhere.to_wgs84(position)->altitude, 70000);
  EXPECT_EQ(nowhere.to_wgs84(position)->heading, 1.0F);
  EXPECT_EQ(nowhere.to_utm(position)->zone, 31);
  CoordinateSettings somewhere = settings(PositionReference::kWgs84);
  somewhere.scale_latitude = 0;
  const PositionWgs84Data there = Coordinates(somewhere, false).to_wgs84(position).value();
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
  const auto again = coordinates.to_utm(*first).value();
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
    const auto by_gk = coordinates.from(coordinates.to_gk(*position).value());
    const auto by_utm = coordinates.from(coordinates.to_utm(*position).value());
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
  // Neither becomes the offset of the world.
  EXPECT_FALSE(coordinates.from(PositionUtmData{std::numeric_limits<i64>::max(), 0, 32, 18, 0, 0}));
  EXPECT_FALSE(coordinates.from(PositionWgs84Data{radians(89), 0, 0, 0}));
  EXPECT_EQ(coordinates.settings().offset_northing, 0);
  Coordinates by_gk(settings(PositionReference::kGaussKrueger), true);
  EXPECT_FALSE(by_gk.from(PositionGkData{1e300, 3.5e9, 0, 0}));
  EXPECT_EQ(by_gk.settings().offset_northing, 0);
}

TEST(Coordinates, PositionsThatAreNoPlaceAreRefused) {
  const PositionData far{.pos = {.x = std::numeric_limits<i32>::max(), .y = -1}};
  CoordinateSettings steep = settings(PositionReference::kWgs84);
  steep.scale_latitude = 1000;
  EXPECT_FALSE(Coordinates(steep, false).to_wgs84(far));
  EXPECT_FALSE(Coordinates(steep, false).to_utm(far));
  EXPECT_FALSE(Coordinates(steep, false).to_gk(far));
  const Coordinates without_offset(settings(PositionReference::kUtm), false);
  const auto place = without_offset.to_wgs84(far);  // easting -1 mm
  ASSERT_FALSE(place);
  EXPECT_NE(place.error().detail().find("asting"), std::string::npos) << place.error().detail();
  EXPECT_TRUE(without_offset.to_utm(far)) << "as it is";
}

}  // namespace coordinates_test

}  // namespace rack::navigation
