// The component that controls the chassis (specification, section 9.18).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct PilotType {
  enum : i8 {
    kSetDestination = 21,       // PilotDestData; ERROR when off or not supported
    kHoldCommand = 22,          // PilotHoldData
    kRevertCommand = 23,        // PilotRevertData
    kGetStatus = 24,            // answered by kStatus; differs from the framework's GET_STATUS
    kStatus = 25,               // PilotStatusData; a reply, although replies are normally < 0
    kSetMultiDestination = 26,  // PilotMultiDestData
    kWatchdog = 27,             // PilotWatchdogData; ours
  };
};

namespace pilot_state {
inline constexpr u32 kIdle = 0;
inline constexpr u32 kPlanning = 1;
inline constexpr u32 kRunning = 2;
inline constexpr u32 kPathError = 3;
}  // namespace pilot_state

struct PilotData {
  TimeStamp recordingTime = 0;
  Position3d pos = {};
  Position3d dest = {};
  MillimetresPerSecond<i32> speed = 0;           // setpoint
  Quantity<f32, unit::PerMillimetre> curve = 0;  // setpoint
  Millimetres<i32> distanceToDest = 0;           // -1: no destination; 0: reached
  u32 pilotState = pilot_state::kIdle;
  Count splineNum = {};
  Sequence<PolarSpline, 1000> splines = {};
};

struct PilotStatusData {  // PilotData without its splines
  TimeStamp recordingTime = 0;
  Position3d pos = {};
  Position3d dest = {};
  MillimetresPerSecond<i32> speed = 0;
  Quantity<f32, unit::PerMillimetre> curve = 0;
  Millimetres<i32> distanceToDest = 0;
  u32 pilotState = pilot_state::kIdle;
};

struct PilotDestData {
  Position3d pos = {};
  MillimetresPerSecond<i32> speed = 0;  // limit
};

struct PilotHoldData {
  i32 holdState = 0;  // 1: hold, 0: release
  Milliseconds<u32> holdTime = 0;
  Position3d pos = {};
};

struct PilotRevertData {
  Milliseconds<u32> revertTime = 0;
};

// From a program that monitors the drive: without another one in time the pilot holds, and goes on
// when the next one arrives. 0, and a new destination, end the watch.
struct PilotWatchdogData {
  Milliseconds<u32> timeout = 0;
};

struct PilotMultiDestData {
  Count pointNum = {};
  Sequence<DestinationPoint, 1000> points = {};  // our limit; the original specifies none
};

class PilotProxy : public DataProxy<PilotData, tims::class_id::kPilot> {
 public:
  using DataProxy::DataProxy;

  Result<void> set_destination(const PilotDestData& destination) {
    return command(PilotType::kSetDestination, destination);
  }
  Result<void> set_multi_destination(const PilotMultiDestData& destinations) {
    return command(PilotType::kSetMultiDestination, destinations);
  }
  Result<void> hold_command(const PilotHoldData& hold) {
    return command(PilotType::kHoldCommand, hold);
  }
  Result<void> revert_command(Milliseconds<u32> revert_time) {
    return command(PilotType::kRevertCommand, PilotRevertData{revert_time});
  }
  Result<void> watchdog(Milliseconds<u32> timeout) {
    return command(PilotType::kWatchdog, PilotWatchdogData{timeout});
  }
  // The content of PilotData without its splines; status() reports whether the pilot is on.
  Result<PilotStatusData> get_status() {
    return query<PilotStatusData>(PilotType::kGetStatus, PilotType::kStatus);
  }
};

}  // namespace rack
