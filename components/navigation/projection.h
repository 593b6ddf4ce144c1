// Coordinates of the Earth on a plane: transverse Mercator, as UTM and Gauss-Krueger have it, and
// the way from WGS84 to the German Gauss-Krueger grid (specification, section 10.5). Pure.
#pragma once

#include "rack/proxies/position.h"

namespace rack::navigation {

struct Geodetic {
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double height = 0;     // m, above the ellipsoid
};

struct Ellipsoid {
  double axis;        // larger one, m
  double flattening;  // inverse
};
inline constexpr Ellipsoid kWgs84{6378137.0, 298.257223563};
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

// Between the globes: a Helmert transformation.
Geodetic wgs84_to_bessel(const Geodetic& at);
Geodetic bessel_to_wgs84(const Geodetic& at);

// --- between the messages. Heading stays as it is; so does altitude, but between the globes.

PositionGkData to_gk(const PositionWgs84Data& from);
PositionWgs84Data to_wgs84(const PositionGkData& from);
PositionUtmData to_utm(const PositionWgs84Data& from);
// zone: 1 to 60, band: N and later are north of the equator.
PositionWgs84Data to_wgs84(const PositionUtmData& from);

}  // namespace rack::navigation
