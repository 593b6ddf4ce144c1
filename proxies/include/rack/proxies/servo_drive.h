// One servo axis; rad for rotary axes, mm for linear ones (specification, section 9.11).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct ServoDriveType {
  enum : i8 {
    kHome = 21,
    kMovePos = 22,          // ServoDriveMovePosData
    kMoveVel = 23,          // ServoDriveMoveVelData
    kInformReached = 24,    // no body is defined
    kPositionReached = -21  // no body is defined
  };
};

struct ServoDriveData {
  TimeStamp recordingTime = 0;
  f32 position = 0;  // rad or mm
};

struct ServoDriveMovePosData {
  f32 position = 0;              // rad or mm
  f32 vel = 0;                   // limit, rad/s or mm/s
  f32 acc = 0;                   // limit, rad/s2 or mm/s2
  i32 replyPositionReached = 0;  // 1: report when the position is reached
};

struct ServoDriveMoveVelData {
  f32 vel = 0;  // rad/s or mm/s
};

class ServoDriveProxy : public DataProxy<ServoDriveData, tims::class_id::kServoDrive> {
 public:
  using DataProxy::DataProxy;

  Result<void> home() { return command(ServoDriveType::kHome); }
  Result<void> move_pos(const ServoDriveMovePosData& move) {
    return command(ServoDriveType::kMovePos, move);
  }
  Result<void> move_vel(f32 vel) {
    return command(ServoDriveType::kMoveVel, ServoDriveMoveVelData{vel});
  }
};

}  // namespace rack
