// A pan-tilt-zoom drive of a camera (specification, section 9.10).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct PtzDriveType {
  enum : i8 {
    kHome = 21,
    kMovePos = 22,          // PtzDriveMovePosData
    kMoveVel = 23,          // PtzDriveMoveVelData
    kInformReached = 24,    // no body is defined
    kPositionReached = -21  // no body is defined
  };
};

struct PtzDriveData {
  TimeStamp recordingTime = 0;
  Radians<f32> posPan = 0;
  Radians<f32> posTilt = 0;
  Percent<f32> posZoom = 0;
};

struct PtzDriveMovePosData {
  Radians<f32> posPan = 0;
  Radians<f32> posTilt = 0;
  Percent<f32> posZoom = 0;
  RadiansPerSecond<f32> velPan = 0;  // limits of speed and acceleration
  RadiansPerSecond<f32> velTilt = 0;
  Quantity<f32, unit::PercentPerSecond> velZoom = 0;
  RadiansPerSecond2<f32> accPan = 0;
  RadiansPerSecond2<f32> accTilt = 0;
  Quantity<f32, unit::PercentPerSecond2> accZoom = 0;
  i32 replyPosReached = 0;  // 1: report when the position is reached
};

struct PtzDriveMoveVelData {
  RadiansPerSecond<f32> velPan = 0;
  RadiansPerSecond<f32> velTilt = 0;
  Quantity<f32, unit::PercentPerSecond> velZoom = 0;
};

class PtzDriveProxy : public DataProxy<PtzDriveData, tims::class_id::kPtzDrive> {
 public:
  using DataProxy::DataProxy;

  Result<void> home() { return command(PtzDriveType::kHome); }
  Result<void> move_pos(const PtzDriveMovePosData& move) {
    return command(PtzDriveType::kMovePos, move);
  }
  Result<void> move_vel(const PtzDriveMoveVelData& move) {
    return command(PtzDriveType::kMoveVel, move);
  }
};

}  // namespace rack
