#include "components/navigation/coordinates.h"

#include <cmath>
#include <limits>
#include <utility>

#include "components/geometry/angle.h"
#include "components/navigation/projection.h"

namespace rack::navigation {
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
  return {tims::Errc::kInvalidArgument, "these are no coordinates of a place on Earth"};
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

PositionData Coordinates::on_plane(const Plane& plane, i32 altitude, f32 heading) {
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
