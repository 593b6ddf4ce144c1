// Places on Earth, as a plane of the robot's world and back: the projections (transverse Mercator,
// as UTM and Gauss-Krueger have it), and what x and y of a position stand for (specification,
// section 10.5). Pure.
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
  double axis;        // larger one, m
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

// Between the globes: a Helmert transformation.
Geodetic wgs84_to_bessel(const Geodetic& at);
Geodetic bessel_to_wgs84(const Geodetic& at);

// --- between the messages. Heading stays as it is; so does altitude, but between the globes.

PositionGkData to_gk(const PositionWgs84Data& from);
PositionWgs84Data to_wgs84(const PositionGkData& from);
PositionUtmData to_utm(const PositionWgs84Data& from);
// zone: 1 to 60, band: N and later are north of the equator.
PositionWgs84Data to_wgs84(const PositionUtmData& from);

// --- Positions in the world of the robot, said as coordinates of the Earth and back

// What x and y of a position are.
enum class PositionReference : i32 {
  kWgs84 = 0,         // metres by a scale for each degree
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
  // auto_offset: the first northing and easting converted, rounded to 100 m, become the offset, and
  // their zone and band of UTM the zone and band of the world.
  Coordinates(const CoordinateSettings& settings, bool auto_offset)
      : settings_(settings), auto_offset_(auto_offset) {}

  tims::Result<PositionData> from(const PositionWgs84Data& wgs84);
  tims::Result<PositionData> from(const PositionGkData& gk);
  tims::Result<PositionData> from(const PositionUtmData& utm);

  // Without a scale every place is where the offset is.
  [[nodiscard]] PositionWgs84Data to_wgs84(const PositionData& position) const;
  [[nodiscard]] PositionGkData to_gk(const PositionData& position) const;
  [[nodiscard]] PositionUtmData to_utm(const PositionData& position) const;

  // With the offsets, zone and band found.
  [[nodiscard]] const CoordinateSettings& settings() const { return settings_; }

 private:
  // As northing and easting, m; the zone of UTM is the one set.
  struct Plane {
    double northing = 0;
    double easting = 0;
  };
  // Whether that place is the first one, and becomes the offset.
  bool find_offset(const Plane& plane);
  [[nodiscard]] PositionData on_plane(const Plane& plane, i32 altitude, f32 heading) const;
  [[nodiscard]] Plane plane_of(const PositionData& position) const;
  [[nodiscard]] PositionGkData gk_of(const PositionData& position) const;
  [[nodiscard]] PositionUtmData utm_of(const PositionData& position) const;

  CoordinateSettings settings_;
  bool auto_offset_;
};

}  // namespace rack::navigation
