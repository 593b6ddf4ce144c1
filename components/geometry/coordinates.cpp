#include "components/geometry/coordinates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "components/geometry/pose.h"

namespace rack::navigation {

namespace {

constexpr i32 kFirstNorthernBand = 12;  // N
constexpr double kFalseEasting = 500000;
constexpr double kFalseNorthing = 10000000;  // UTM, south of the equator

// Krueger's series in n, the third flattening; exact to a millimetre within about 3000 km.
struct Series {
  explicit Series(const Ellipsoid& ellipsoid) {
    const double f = 1 / ellipsoid.flattening;
    const double n = f / (2 - f);
    const double n2 = n * n;
    const double n3 = n2 * n;
    radius = ellipsoid.axis / (1 + n) * (1 + n2 / 4 + n2 * n2 / 64);
    eccentricity = std::sqrt(f * (2 - f));
    alpha = {n / 2 - 2 * n2 / 3 + 5 * n3 / 16, 13 * n2 / 48 - 3 * n3 / 5, 61 * n3 / 240};
    beta = {n / 2 - 2 * n2 / 3 + 37 * n3 / 96, n2 / 48 + n3 / 15, 17 * n3 / 480};
    delta = {2 * n - 2 * n2 / 3 - 2 * n3, 7 * n2 / 3 - 8 * n3 / 5, 56 * n3 / 15};
  }
  double radius;  // of a sphere with a meridian of the same length
  double eccentricity;
  std::array<double, 3> alpha;
  std::array<double, 3> beta;
  std::array<double, 3> delta;
};

// Earth-centred coordinates, m.
struct Vector {
  double x;
  double y;
  double z;
};

Vector to_vector(const Geodetic& at, const Ellipsoid& ellipsoid) {
  const double f = 1 / ellipsoid.flattening;
  const double e2 = f * (2 - f);
  const double s = std::sin(at.latitude);
  const double radius = ellipsoid.axis / std::sqrt(1 - e2 * s * s);
  const double across = (radius + at.height) * std::cos(at.latitude);
  return {across * std::cos(at.longitude), across * std::sin(at.longitude),
          (radius * (1 - e2) + at.height) * s};
}

// Bowring's formula: the error is far below a millimetre near the ground.
Geodetic to_geodetic(const Vector& at, const Ellipsoid& ellipsoid) {
  const double f = 1 / ellipsoid.flattening;
  const double e2 = f * (2 - f);
  const double b = ellipsoid.axis * (1 - f);
  const double p = std::hypot(at.x, at.y);
  const double theta = std::atan2(at.z * ellipsoid.axis, p * b);
  const double s = std::sin(theta);
  const double c = std::cos(theta);
  const double latitude =
      std::atan2(at.z + e2 / (1 - e2) * b * s * s * s, p - e2 * ellipsoid.axis * c * c * c);
  const double sine = std::sin(latitude);
  const double height =
      p * std::cos(latitude) + at.z * sine - ellipsoid.axis * std::sqrt(1 - e2 * sine * sine);
  return {latitude, std::atan2(at.y, at.x), height};
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

double zone_meridian(i32 zone) { return radians(6 * zone - 183); }
double gk_meridian(double zone) { return radians(3 * zone); }

}  // namespace

PlanePoint project(const Geodetic& at, const Grid& grid) {
  const Series series(grid.ellipsoid);
  const double e = series.eccentricity;
  const double s = std::sin(at.latitude);
  const double t = std::sinh(std::atanh(s) - e * std::atanh(e * s));
  const double away = at.longitude - grid.meridian;
  const double xi = std::atan2(t, std::cos(away));
  const double eta = std::atanh(std::sin(away) / std::sqrt(1 + t * t));
  PlanePoint point{xi, eta};
  for (std::size_t j = 0; j < series.alpha.size(); ++j) {
    const double k = 2 * static_cast<double>(j + 1);
    point.north += series.alpha[j] * std::sin(k * xi) * std::cosh(k * eta);
    point.east += series.alpha[j] * std::cos(k * xi) * std::sinh(k * eta);
  }
  return {grid.scale * series.radius * point.north, grid.scale * series.radius * point.east};
}

Geodetic unproject(const PlanePoint& point, const Grid& grid) {
  const Series series(grid.ellipsoid);
  const double xi = point.north / (grid.scale * series.radius);
  const double eta = point.east / (grid.scale * series.radius);
  double xi0 = xi;
  double eta0 = eta;
  for (std::size_t j = 0; j < series.beta.size(); ++j) {
    const double k = 2 * static_cast<double>(j + 1);
    xi0 -= series.beta[j] * std::sin(k * xi) * std::cosh(k * eta);
    eta0 -= series.beta[j] * std::cos(k * xi) * std::sinh(k * eta);
  }
  const double chi = std::asin(std::sin(xi0) / std::cosh(eta0));
  double latitude = chi;
  for (std::size_t j = 0; j < series.delta.size(); ++j)
    latitude += series.delta[j] * std::sin(2 * static_cast<double>(j + 1) * chi);
  return {latitude, grid.meridian + std::atan2(std::sinh(eta0), std::cos(xi0)), 0};
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

PositionGkData to_gk(const PositionWgs84Data& from) {
  const Geodetic at = wgs84_to_bessel({from.latitude, from.longitude, from.altitude.si()});
  const double zone = std::round(degrees(at.longitude) / 3);
  const PlanePoint point = project(at, {kBessel, 1, gk_meridian(zone)});
  return {.northing = point.north * 1000,
          .easting = (zone * 1e6 + kFalseEasting + point.east) * 1000,
          .altitude = Millimetres<i32>::from_si(at.height),
          .heading = from.heading};
}

PositionWgs84Data to_wgs84(const PositionGkData& from) {
  const double easting = from.easting / 1000;
  const double zone = std::floor(easting / 1e6);
  Geodetic bessel = unproject({from.northing / 1000, easting - zone * 1e6 - kFalseEasting},
                              {kBessel, 1, gk_meridian(zone)});
  bessel.height = from.altitude.si();
  const Geodetic at = bessel_to_wgs84(bessel);
  return {at.latitude, at.longitude, Millimetres<i32>::from_si(at.height), from.heading};
}

PositionUtmData to_utm(const PositionWgs84Data& from) {
  const double longitude = degrees(signed_angle(from.longitude));
  const double latitude = degrees(from.latitude);
  const auto zone = static_cast<i32>(std::clamp(std::floor((longitude + 180) / 6) + 1, 1.0, 60.0));
  // The bands start with C at 80 degrees south and have 8 degrees each; X is larger.
  const auto band = static_cast<i32>(std::clamp(std::floor((latitude + 80) / 8), 0.0, 19.0)) + 2;
  const PlanePoint point =
      project({from.latitude, radians(longitude), 0}, {kEarth, 0.9996, zone_meridian(zone)});
  const double south = band < kFirstNorthernBand ? kFalseNorthing : 0;
  return {.northing = Millimetres<i64>::from_si(point.north + south),
          .easting = Millimetres<i64>::from_si(point.east + kFalseEasting),
          .zone = zone,
          .band = band,
          .altitude = from.altitude,
          .heading = from.heading};
}

PositionWgs84Data to_wgs84(const PositionUtmData& from) {
  const double south = from.band < kFirstNorthernBand ? kFalseNorthing : 0;
  const Geodetic at = unproject({from.northing.si() - south, from.easting.si() - kFalseEasting},
                                {kEarth, 0.9996, zone_meridian(from.zone)});
  return {at.latitude, at.longitude, from.altitude, from.heading};
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

bool good(const PositionWgs84Data& wgs84) {
  return std::abs(wgs84.latitude) <= kPi / 2 && std::abs(wgs84.longitude) <= 2 * kPi;
}

bool good(const PositionUtmData& utm) {
  return utm.zone >= 1 && utm.zone <= 60 && utm.band >= 0 && utm.band < 24;
}

tims::Error no_place() {
  return {tims::Errc::kInvalidArgument, "these are not coordinates of a place on Earth"};
}

}  // namespace

tims::Result<PositionData> Coordinates::from(const PositionWgs84Data& wgs84) {
  if (!good(wgs84)) return no_place();
  switch (settings_.reference) {
    case PositionReference::kGaussKrueger:
      return from(navigation::to_gk(wgs84));
    case PositionReference::kUtm:
      return from(navigation::to_utm(wgs84));
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
  if (!std::isfinite(gk.northing.raw()) || !std::isfinite(gk.easting.raw())) return no_place();
  if (settings_.reference != PositionReference::kGaussKrueger)
    return from(navigation::to_wgs84(gk));
  const Plane plane{gk.northing.si(), gk.easting.si()};
  find_offset(plane);
  return on_plane(plane, gk.altitude, gk.heading);
}

tims::Result<PositionData> Coordinates::from(const PositionUtmData& utm) {
  if (!good(utm)) return no_place();
  if (settings_.reference != PositionReference::kUtm) return from(navigation::to_wgs84(utm));
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

PositionWgs84Data Coordinates::to_wgs84(const PositionData& position) const {
  if (settings_.reference == PositionReference::kGaussKrueger)
    return navigation::to_wgs84(gk_of(position));
  if (settings_.reference == PositionReference::kUtm) return navigation::to_wgs84(utm_of(position));
  const auto angle = [](double metres, double scale, double offset) {
    return radians(scale == 0 ? offset : metres / scale + offset);
  };
  return {angle(position.pos.x.si(), settings_.scale_latitude, settings_.offset_latitude),
          angle(position.pos.y.si(), settings_.scale_longitude, settings_.offset_longitude),
          altitude_of(position), position.pos.rho};
}

PositionGkData Coordinates::to_gk(const PositionData& position) const {
  if (settings_.reference == PositionReference::kGaussKrueger) return gk_of(position);
  return navigation::to_gk(to_wgs84(position));
}

PositionUtmData Coordinates::to_utm(const PositionData& position) const {
  if (settings_.reference == PositionReference::kUtm) return utm_of(position);
  return navigation::to_utm(to_wgs84(position));
}

}  // namespace rack::navigation
