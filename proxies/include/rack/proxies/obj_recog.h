// Recognised and tracked objects (specification, section 9.20).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct ObjRecogType {
  enum : i8 {
    kSetEstimate = 21,  // ObjRecogData
    kStopRecog = 22,    // ObjRecogData
  };
};

namespace object_type {
inline constexpr i32 kUnclassified = 0;
inline constexpr i32 kUnknownSmall = 1;
inline constexpr i32 kUnknownBig = 2;
inline constexpr i32 kPedestrian = 3;
inline constexpr i32 kBike = 4;
inline constexpr i32 kCar = 5;
inline constexpr i32 kTruck = 6;
}  // namespace object_type

struct ObjRecogObject {
  i32 objectId = 0;
  i32 type = object_type::kUnclassified;
  Position3d pos = {};     // centre
  Position3d varPos = {};  // standard deviations
  Velocity3d vel = {};
  Velocity3d varVel = {};
  Point3d dim = {};  // of the bounding box
  f32 prob = 0;      // probability of existence, 0 to 1
  ImageRect imageArea = {};
};

struct ObjRecogData {
  TimeStamp recordingTime = 0;
  Position3d refPos = {};  // of the objects
  Position3d varRefPos = {};
  Count objectNum = {};
  // Original programs accept up to 100 objects, those built for the Velodyne laser 300.
  Sequence<ObjRecogObject, 300> objects = {};
};

class ObjRecogProxy : public DataProxy<ObjRecogData, tims::class_id::kObjRecog> {
 public:
  using DataProxy::DataProxy;

  Result<void> set_estimate(const ObjRecogData& estimate) {
    return command(ObjRecogType::kSetEstimate, estimate);
  }
  Result<void> stop_recog(const ObjRecogData& objects) {
    return command(ObjRecogType::kStopRecog, objects);
  }
};

}  // namespace rack
