#include "components/geometry/coordinates.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/MGRS.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include "components/geometry/pose.h"

namespace rack::navigation {

namespace {

using GeographicLib::Geocentric;
using GeographicLib::GeographicErr;
using GeographicLib::MGRS;
using GeographicLib::TransverseMercator;
using GeographicLib::UTMUPS;

constexpr std::string_view kBands = "ABCDEFGHJKLMNPQRSTUVWXYZ";
constexpr i32 kFirstBand = 2;           // C
constexpr i32 kFirstNorthernBand = 12;  // N
constexpr i32 kLastBand = 21;           // X
constexpr double kSouthEnd = -80;       // deg; UTM is not defined beyond
constexpr double kNorthEnd = 84;
constexpr double kFalseEasting = 500000;    // Gauss-Krueger, m
constexpr double kZoneOfGk = 3;             // deg
constexpr double kPoleNorthing = 10002000;  // m; the pole of each ellipsoid is a little nearer

tims::Error no_place(const std::string& reason = {}) {
  return {tims::Errc::kInvalidArgument,
          "these are not coordinates of a place on Earth" + (reason.empty() ? "" : ": " + reason)};
}

bool is_place(const PositionWgs84Data& at) {  // false also for values that are not numbers
  return std::abs(at.latitude) <= kPi / 2 && std::abs(at.longitude) <= 2 * kPi;
}

// Earth-centred coordinates, m.
struct Vector {
  double x = 0;
  double y = 0;
  double z = 0;
};

Geocentric geocentric(const Ellipsoid& ellipsoid) {
  return {ellipsoid.axis, 1 / ellipsoid.flattening};
}

Vector to_vector(const Geodetic& at, const Ellipsoid& ellipsoid) {
  Vector v;
  geocentric(ellipsoid).Forward(degrees(at.latitude), degrees(at.longitude), at.height, v.x, v.y,
                                v.z);
  return v;
}

Geodetic to_geodetic(const Vector& v, const Ellipsoid& ellipsoid) {
  double latitude = 0;
  double longitude = 0;
  double height = 0;
  geocentric(ellipsoid).Reverse(v.x, v.y, v.z, latitude, longitude, height);
  return {radians(latitude), radians(longitude), height};
}

// The constants of the original, from WGS84 to Bessel; the rotation is that of the frame, not of
// the vector. The original has a scale of 1 / (1 - 9.82e-6), which would raise the ground by 125 m;
// the inverse is correct.
constexpr Vector kShift{-591.28, -81.35, -396.39};
constexpr Vector kTurn{7.1606980699878466e-6, -3.568228692966184e-7, -7.068583470577034e-6};
constexpr double kScale = 1 - 9.82e-6;

Vector turned(const Vector& v, double sign) {
  const Vector r{sign * kTurn.x, sign * kTurn.y, sign * kTurn.z};
  return {v.x + r.z * v.y - r.y * v.z, -r.z * v.x + v.y + r.x * v.z, r.y * v.x - r.x * v.y + v.z};
}

TransverseMercator projection(const Grid& grid) {
  return {grid.ellipsoid.axis, 1 / grid.ellipsoid.flattening, grid.scale};
}

double utm_meridian(i32 zone) { return radians(6 * zone - 183); }

Grid gk_grid(double zone) { return {kBessel, 1, radians(kZoneOfGk * zone)}; }

// Easting without its zone number.
struct GkPlace {
  double zone = 0;
  double northing = 0;  // m
  double easting = 0;   // m, from the meridian
};

// Zones are counted to the east from Greenwich: to 119, or from -60 to 60.
tims::Result<GkPlace> gk_place(const PositionGkData& gk) {
  constexpr double kZoneWidth = 1e6;  // of the numbers, m
  GkPlace place{.northing = gk.northing.si()};
  place.zone = std::floor(gk.easting.si() / kZoneWidth);
  place.easting = gk.easting.si() - place.zone * kZoneWidth - kFalseEasting;
  if (!std::isfinite(place.zone) || place.zone < -60 || place.zone > 119)
    return no_place("the easting has no zone of Gauss-Krueger");
  if (!(std::abs(place.northing) <= kPoleNorthing))
    return no_place("the northing is beyond a pole");
  return place;
}

}  // namespace

PlanePoint project(const Geodetic& at, const Grid& grid) {
  PlanePoint point;
  projection(grid).Forward(degrees(grid.meridian), degrees(at.latitude), degrees(at.longitude),
                           point.east, point.north);
  return point;
}

Geodetic unproject(const PlanePoint& point, const Grid& grid) {
  double latitude = 0;
  double longitude = 0;
  projection(grid).Reverse(degrees(grid.meridian), point.east, point.north, latitude, longitude);
  return {radians(latitude), radians(longitude), 0};
}

Grid utm_grid(const Geodetic& at) {
  const int zone = UTMUPS::StandardZone(degrees(at.latitude), degrees(at.longitude), UTMUPS::UTM);
  return {kEarth, GeographicLib::Constants::UTM_k0(), utm_meridian(zone)};
}

Geodetic wgs84_to_bessel(const Geodetic& at) {
  const Vector v = turned(to_vector(at, kEarth), 1);
  return to_geodetic({kShift.x + kScale * v.x, kShift.y + kScale * v.y, kShift.z + kScale * v.z},
                     kBessel);
}

Geodetic bessel_to_wgs84(const Geodetic& at) {
  const Vector v = to_vector(at, kBessel);
  return to_geodetic(
      turned({(v.x - kShift.x) / kScale, (v.y - kShift.y) / kScale, (v.z - kShift.z) / kScale}, -1),
      kEarth);
}

tims::Result<PositionGkData> to_gk(const PositionWgs84Data& from) {
  if (!is_place(from)) return no_place();
  const Geodetic at = wgs84_to_bessel({from.latitude, from.longitude, from.altitude.si()});
  const double zone = std::round(degrees(at.longitude) / kZoneOfGk);
  const PlanePoint point = project(at, gk_grid(zone));
  return PositionGkData{.northing = point.north * 1000,
                        .easting = (zone * 1e6 + kFalseEasting + point.east) * 1000,
                        .altitude = Millimetres<i32>::from_si(at.height),
                        .heading = from.heading};
}

tims::Result<PositionWgs84Data> to_wgs84(const PositionGkData& from) {
  const auto place = gk_place(from);
  if (!place) return place.error();
  Geodetic bessel = unproject({place->northing, place->easting}, gk_grid(place->zone));
  bessel.height = from.altitude.si();
  const Geodetic at = bessel_to_wgs84(bessel);
  return PositionWgs84Data{at.latitude, at.longitude, Millimetres<i32>::from_si(at.height),
                           from.heading};
}

tims::Result<PositionUtmData> to_utm(const PositionWgs84Data& from) {
  if (!is_place(from)) return no_place();
  if (from.latitude < radians(kSouthEnd) || from.latitude > radians(kNorthEnd))
    return tims::Error{tims::Errc::kInvalidArgument,
                       "UTM ends at 80 degrees south and 84 degrees north; nearer to a pole use "
                       "positionReference 0 (WGS84)"};
  const double latitude = degrees(from.latitude);
  int zone = 0;
  bool is_north = false;
  double easting = 0;
  double northing = 0;
  std::string designation;  // "32U"
  try {
    UTMUPS::Forward(latitude, degrees(from.longitude), zone, is_north, easting, northing,
                    UTMUPS::UTM);
    MGRS::Forward(zone, is_north, easting, northing, latitude, -1, designation);
  } catch (const GeographicErr& error) {
    return no_place(error.what());
  }
  return PositionUtmData{.northing = Millimetres<i64>::from_si(northing),
                         .easting = Millimetres<i64>::from_si(easting),
                         .zone = zone,
                         .band = static_cast<i32>(kBands.find(designation.back())),
                         .altitude = from.altitude,
                         .heading = from.heading};
}

tims::Result<PositionWgs84Data> to_wgs84(const PositionUtmData& from) {
  if (from.zone < UTMUPS::MINUTMZONE || from.zone > UTMUPS::MAXUTMZONE)
    return no_place("UTM zones are 1 to 60, not " + std::to_string(from.zone));
  if (from.band < kFirstBand || from.band > kLastBand)
    return no_place("UTM bands are 2 (C) to 21 (X), not " + std::to_string(from.band));
  double latitude = 0;
  double longitude = 0;
  try {
    UTMUPS::Reverse(from.zone, from.band >= kFirstNorthernBand, from.easting.si(),
                    from.northing.si(), latitude, longitude);
  } catch (const GeographicErr& error) {
    return no_place(error.what());
  }
  return PositionWgs84Data{radians(latitude), radians(longitude), from.altitude, from.heading};
}

namespace {

constexpr double kRound = 100;  // m

Position3d position_of(double north_m, double east_m, i32 altitude, f32 direction) {
  return {.x = Millimetres<i32>::from_si(north_m),
          .y = Millimetres<i32>::from_si(east_m),
          .z = altitude == std::numeric_limits<i32>::min() ? std::numeric_limits<i32>::max()
                                                           : -altitude,
          .rho = static_cast<f32>(heading(direction))};
}

i32 altitude_of(const PositionData& position) {
  return Millimetres<i32>::from_si(-position.pos.z.si());
}

// Converts a place to another kind of coordinates, and those to a position of the world.
template <typename To>
tims::Result<PositionData> through(Coordinates& coordinates, const tims::Result<To>& place) {
  if (!place) return place.error();
  return coordinates.from(*place);
}

}  // namespace

tims::Result<PositionData> Coordinates::from(const PositionWgs84Data& wgs84) {
  if (!is_place(wgs84)) return no_place();
  switch (settings_.reference) {
    case PositionReference::kGaussKrueger:
      return through(*this, navigation::to_gk(wgs84));
    case PositionReference::kUtm:
      return through(*this, navigation::to_utm(wgs84));
    case PositionReference::kWgs84:
      break;
  }
  PositionData position;
  position.pos = position_of(
      (degrees(wgs84.latitude) - settings_.offset_latitude) * settings_.scale_latitude,
      (degrees(wgs84.longitude) - settings_.offset_longitude) * settings_.scale_longitude,
      wgs84.altitude, wgs84.heading);
  return position;
}

tims::Result<PositionData> Coordinates::from(const PositionGkData& gk) {
  if (settings_.reference != PositionReference::kGaussKrueger)
    return through(*this, navigation::to_wgs84(gk));
  if (const auto place = gk_place(gk); !place) return place.error();
  const Plane plane{gk.northing.si(), gk.easting.si()};
  find_offset(plane);
  return on_plane(plane, gk.altitude, gk.heading);
}

tims::Result<PositionData> Coordinates::from(const PositionUtmData& utm) {
  const auto place = navigation::to_wgs84(utm);
  if (settings_.reference != PositionReference::kUtm) return through(*this, place);
  if (!place) return place.error();
  const Plane plane{utm.northing.si(), utm.easting.si()};
  if (find_offset(plane)) {
    settings_.utm_zone = utm.zone;
    settings_.utm_band = utm.band;
  }
  return on_plane(plane, utm.altitude, utm.heading);
}

bool Coordinates::find_offset(const Plane& plane) {
  if (!std::exchange(auto_offset_, false)) return false;
  settings_.offset_northing = static_cast<i32>(std::round(plane.northing / kRound) * kRound);
  settings_.offset_easting = static_cast<i32>(std::round(plane.easting / kRound) * kRound);
  return true;
}

PositionData Coordinates::on_plane(const Plane& plane, i32 altitude, f32 heading) const {
  PositionData position;
  position.pos = position_of(plane.northing - settings_.offset_northing,
                             plane.easting - settings_.offset_easting, altitude, heading);
  return position;
}

Coordinates::Plane Coordinates::plane_of(const PositionData& position) const {
  return {position.pos.x.si() + settings_.offset_northing,
          position.pos.y.si() + settings_.offset_easting};
}

PositionGkData Coordinates::gk_of(const PositionData& position) const {
  const Plane plane = plane_of(position);
  return {plane.northing * 1000, plane.easting * 1000, altitude_of(position), position.pos.rho};
}

PositionUtmData Coordinates::utm_of(const PositionData& position) const {
  const Plane plane = plane_of(position);
  return {.northing = Millimetres<i64>::from_si(plane.northing),
          .easting = Millimetres<i64>::from_si(plane.easting),
          .zone = settings_.utm_zone,
          .band = settings_.utm_band,
          .altitude = altitude_of(position),
          .heading = position.pos.rho};
}

tims::Result<PositionWgs84Data> Coordinates::to_wgs84(const PositionData& position) const {
  if (settings_.reference == PositionReference::kGaussKrueger)
    return navigation::to_wgs84(gk_of(position));
  if (settings_.reference == PositionReference::kUtm) return navigation::to_wgs84(utm_of(position));
  const auto angle = [](double metres, double scale, double offset) {
    return radians(scale == 0 ? offset : metres / scale + offset);
  };
  const PositionWgs84Data place{
      angle(position.pos.x.si(), settings_.scale_latitude, settings_.offset_latitude),
      angle(position.pos.y.si(), settings_.scale_longitude, settings_.offset_longitude),
      altitude_of(position), position.pos.rho};
  if (!is_place(place)) return no_place("check scaleLatitude and scaleLongitude");
  return place;
}

tims::Result<PositionGkData> Coordinates::to_gk(const PositionData& position) const {
  if (settings_.reference == PositionReference::kGaussKrueger) return gk_of(position);
  const auto place = to_wgs84(position);
  if (!place) return place.error();
  return navigation::to_gk(*place);
}

tims::Result<PositionUtmData> Coordinates::to_utm(const PositionData& position) const {
  if (settings_.reference == PositionReference::kUtm) return utm_of(position);
  const auto place = to_wgs84(position);
  if (!place) return place.error();
  return navigation::to_utm(*place);
}

}  // namespace rack::navigation
