#include "proxies/body_info.h"
#include "proxies/catalogue_tables.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/compass.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/gyro.h"
#include "rack/proxies/io.h"
#include "rack/proxies/joystick.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/ptz_drive.h"
#include "rack/proxies/servo_drive.h"
#include "rack/proxies/vehicle.h"

namespace rack {

namespace {

using namespace tims::class_id;
constexpr i8 kData = tims::type::kData;

static_assert(kNoPilot == kNobody);

constexpr MessageInfo kMessages[] = {
    {kCamera, kData, "DATA", kBody<CameraData>},
    {kCamera, CameraType::kGetParameter, "GET_PARAMETER"},
    {kCamera, CameraType::kSetFormat, "SET_FORMAT", kBody<CameraFormatData>},
    {kCamera, CameraType::kParameter, "PARAMETER", kBody<CameraParamData>},
    {kCamera, CameraType::kFormat, "FORMAT", kBody<CameraFormatData>},

    {kChassis, kData, "DATA", kBody<ChassisData>},
    {kChassis, ChassisType::kMove, "MOVE", kBody<ChassisMoveData>},
    {kChassis, ChassisType::kGetParameter, "GET_PARAMETER"},
    {kChassis, ChassisType::kSetActivePilot, "SET_ACTIVE_PILOT", kBody<ChassisSetActivePilotData>},
    {kChassis, ChassisType::kParameter, "PARAMETER", kBody<ChassisParamData>},

    {kClock, kData, "DATA", kBody<ClockData>},
    {kCompass, kData, "DATA", kBody<CompassData>},
    {kGps, kData, "DATA", kBody<GpsData>},
    {kGyro, kData, "DATA", kBody<GyroData>},

    {kIo, kData, "DATA", kBody<IoData>},
    {kIo, IoType::kSetData, "SET_DATA", kBody<IoData>},

    {kJoystick, kData, "DATA", kBody<JoystickData>},
    {kLadar, kData, "DATA", kBody<LadarData>},

    {kPtzDrive, kData, "DATA", kBody<PtzDriveData>},
    {kPtzDrive, PtzDriveType::kHome, "HOME"},
    {kPtzDrive, PtzDriveType::kMovePos, "MOVE_POS", kBody<PtzDriveMovePosData>},
    {kPtzDrive, PtzDriveType::kMoveVel, "MOVE_VEL", kBody<PtzDriveMoveVelData>},
    {kPtzDrive, PtzDriveType::kInformReached, "INFORM_REACHED"},
    {kPtzDrive, PtzDriveType::kPositionReached, "POSITION_REACHED"},

    {kServoDrive, kData, "DATA", kBody<ServoDriveData>},
    {kServoDrive, ServoDriveType::kHome, "HOME"},
    {kServoDrive, ServoDriveType::kMovePos, "MOVE_POS", kBody<ServoDriveMovePosData>},
    {kServoDrive, ServoDriveType::kMoveVel, "MOVE_VEL", kBody<ServoDriveMoveVelData>},
    {kServoDrive, ServoDriveType::kInformReached, "INFORM_REACHED"},
    {kServoDrive, ServoDriveType::kPositionReached, "POSITION_REACHED"},

    {kVehicle, kData, "DATA", kBody<VehicleData>},
    {kVehicle, VehicleType::kSetValue, "SET_VALUE", kBody<VehicleSetValueData>},
};

}  // namespace

std::span<const MessageInfo> driver_messages() { return kMessages; }

}  // namespace rack
