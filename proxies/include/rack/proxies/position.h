// Position of the robot in the world, and its conversion to other coordinate systems
// (specification, section 9.19).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct PositionType {
  enum : i8 {
    kUpdate = 21,      // PositionData; ERROR when there is no odometry for its time
    kWgs84ToPos = 22,  // PositionWgs84Data; answered by kPos
    kPosToWgs84 = 23,  // PositionData; answered by kWgs84
    kGkToPos = 24,     // PositionGkData; answered by kPos
    kPosToGk = 25,     // PositionData; answered by kGk
    kUtmToPos = 26,    // PositionUtmData; answered by kPos
    kPosToUtm = 27,    // PositionData; answered by kUtm
    kPos = -22,        // PositionData
    kWgs84 = -23,
    kGk = -25,
    kUtm = -27,
  };
};

struct PositionData {
  TimeStamp recordingTime = 0;
  Position3d pos = {};
  Position3d var = {};  // standard deviations
};

struct PositionWgs84Data {
  Radians<f64> latitude = 0;
  Radians<f64> longitude = 0;
  Millimetres<i32> altitude = 0;  // up
  Radians<f32> heading = 0;       // 0: north
};

struct PositionGkData {  // Gauss-Krueger
  Millimetres<f64> northing = 0;
  Millimetres<f64> easting = 0;
  Millimetres<i32> altitude = 0;
  Radians<f32> heading = 0;
};

struct PositionUtmData {
  Millimetres<i64> northing = 0;  // 0 to 1e10
  Millimetres<i64> easting = 0;   // 1e8 to 9e8
  i32 zone = 0;                   // 1 to 60
  i32 band = 0;                   // index into ABCDEFGHJKLMNPQRSTUVWXYZ
  Millimetres<i32> altitude = 0;
  Radians<f32> heading = 0;
};

class PositionProxy : public DataProxy<PositionData, tims::class_id::kPosition> {
 public:
  using DataProxy::DataProxy;

  Result<void> update(const PositionData& position) {
    return command(PositionType::kUpdate, position);
  }
  Result<PositionData> wgs84_to_pos(const PositionWgs84Data& wgs84) {
    return query<PositionData>(PositionType::kWgs84ToPos, wgs84, PositionType::kPos);
  }
  Result<PositionWgs84Data> pos_to_wgs84(const PositionData& position) {
    return query<PositionWgs84Data>(PositionType::kPosToWgs84, position, PositionType::kWgs84);
  }
  Result<PositionData> gk_to_pos(const PositionGkData& gk) {
    return query<PositionData>(PositionType::kGkToPos, gk, PositionType::kPos);
  }
  Result<PositionGkData> pos_to_gk(const PositionData& position) {
    return query<PositionGkData>(PositionType::kPosToGk, position, PositionType::kGk);
  }
  Result<PositionData> utm_to_pos(const PositionUtmData& utm) {
    return query<PositionData>(PositionType::kUtmToPos, utm, PositionType::kPos);
  }
  Result<PositionUtmData> pos_to_utm(const PositionData& position) {
    return query<PositionUtmData>(PositionType::kPosToUtm, position, PositionType::kUtm);
  }
};

}  // namespace rack
