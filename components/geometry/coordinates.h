// Coordinates of the Earth as a plane of the robot's world, and back. A transverse Mercator
// projection unrolls a cylinder that touches the Earth along a meridian: UTM on the ellipsoid of
// satellite receivers (WGS84), Gauss-Krueger on that of old German maps (Bessel). The projections
// and zones are GeographicLib's; the shift between the ellipsoids and the meaning of x and y of a
// position are those of the original (specification, section 10.5). Pure.
#pragma once

#include <string>

#include "rack/proxies/position.h"
#include "tims/result.h"

namespace rack::navigation {

// --- Coordinates of the Earth on a plane

struct Geodetic {
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double height = 0;     // m, above the ellipsoid
};

struct Ellipsoid {
  double axis;        // semi-major axis, m
  double flattening;  // inverse
};
inline constexpr Ellipsoid kEarth{6378137.0, 298.257223563};
inline constexpr Ellipsoid kBessel{6377397.15508, 299.15281285};

// A transverse Mercator grid around one meridian.
struct Grid {
  Ellipsoid ellipsoid;
  double scale;     // on the meridian
  double meridian;  // rad
};
struct PlanePoint {
  double north = 0;  // m, from the equator
  double east = 0;   // m, from the meridian
};
PlanePoint project(const Geodetic& at, const Grid& grid);
Geodetic unproject(const PlanePoint& point, const Grid& grid);
// The grid of the UTM zone that contains the place.
Grid utm_grid(const Geodetic& at);

// Between the ellipsoids: a Helmert transformation.
Geodetic wgs84_to_bessel(const Geodetic& at);
Geodetic bessel_to_wgs84(const Geodetic& at);

// --- between the messages. Heading and altitude are kept; the altitude changes between ellipsoids.
// What is not a place is an error kInvalidArgument: latitudes beyond the poles, values that are
// not numbers, longitudes of more than a turn, zones and bands that do not exist.

// Zones of 3 degrees around the meridian zone * 3: from -60 to 60, read up to 119. At the poles any
// longitude is correct.
tims::Result<PositionGkData> to_gk(const PositionWgs84Data& from);
tims::Result<PositionWgs84Data> to_wgs84(const PositionGkData& from);

// From 80 degrees south to 84 degrees north, both included; nearer to a pole is an error. Each
// place is in its own zone, with the exceptions for Norway (32V) and Svalbard (31X, 33X, 35X, 37X).
// The meridian of 180 degrees is in zone 1, the equator in band N.
tims::Result<PositionUtmData> to_utm(const PositionWgs84Data& from);
// zone: 1 to 60, band: C to X; N and later are north of the equator. The easting may be 0 to 1000
// km, which overlaps the neighbouring zones.
tims::Result<PositionWgs84Data> to_wgs84(const PositionUtmData& from);

// --- Positions in the world of the robot as coordinates of the Earth, and back

// The meaning of x and y of a position.
enum class PositionReference : i32 {
  kWgs84 = 0,         // metres, by a scale per degree
  kGaussKrueger = 1,  // northing and easting
  kUtm = 2,
};

struct CoordinateSettings {
  PositionReference reference = PositionReference::kWgs84;
  double offset_latitude = 0;   // deg
  double offset_longitude = 0;  // deg
  double scale_latitude = 0;    // m/deg
  double scale_longitude = 0;   // m/deg
  i32 offset_northing = 0;      // m
  i32 offset_easting = 0;       // m
  i32 utm_zone = 32;
  i32 utm_band = 18;
};

class Coordinates {
 public:
  // auto_offset: the first converted northing and easting, rounded to 100 m, become the offset, and
  // their UTM zone and band those of the world.
  Coordinates(const CoordinateSettings& settings, bool auto_offset)
      : settings_(settings), auto_offset_(auto_offset) {}

  tims::Result<PositionData> from(const PositionWgs84Data& wgs84);
  tims::Result<PositionData> from(const PositionGkData& gk);
  tims::Result<PositionData> from(const PositionUtmData& utm);

  // Without a scale, every position maps to the offset.
  [[nodiscard]] tims::Result<PositionWgs84Data> to_wgs84(const PositionData& position) const;
  [[nodiscard]] tims::Result<PositionGkData> to_gk(const PositionData& position) const;
  [[nodiscard]] tims::Result<PositionUtmData> to_utm(const PositionData& position) const;

  // Including offsets, zone and band found by auto_offset.
  [[nodiscard]] const CoordinateSettings& settings() const { return settings_; }

 private:
  // Northing and easting, m, in the configured UTM zone.
  struct Plane {
    double northing = 0;
    double easting = 0;
  };
  // Sets the offset from the first place; returns whether it is the first one.
  bool find_offset(const Plane& plane);
  [[nodiscard]] PositionData on_plane(const Plane& plane, i32 altitude, f32 heading) const;
  [[nodiscard]] Plane plane_of(const PositionData& position) const;
  [[nodiscard]] PositionGkData gk_of(const PositionData& position) const;
  [[nodiscard]] PositionUtmData utm_of(const PositionData& position) const;

  CoordinateSettings settings_;
  bool auto_offset_;
};

}  // namespace rack::navigation
