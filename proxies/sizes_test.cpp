// Every struct has the size that the specification's tables give (section 9).
#include "rack/proxies/camera.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/compass.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/gdos_log.h"
#include "rack/proxies/generic.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/gyro.h"
#include "rack/proxies/io.h"
#include "rack/proxies/joystick.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/planner.h"
#include "rack/proxies/position.h"
#include "rack/proxies/ptz_drive.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d.h"
#include "rack/proxies/servo_drive.h"
#include "rack/proxies/vehicle.h"
#include "rack/proxies/world.h"

namespace rack {
namespace {

static_assert(wire_size<Position2d>() == 12);
static_assert(wire_size<Position3d>() == 24);
static_assert(wire_size<Velocity3d>() == 24);
static_assert(wire_size<Point2d>() == 8);
static_assert(wire_size<Point3d>() == 12);
static_assert(wire_size<ImageRect>() == 16);
static_assert(wire_size<DestinationPoint>() == 28);
static_assert(wire_size<Waypoint2d>() == 48);
static_assert(wire_size<PolarSpline>() == 124);
static_assert(wire_size<ScanPoint>() == 20);
// Structs that are sent in large numbers must be copyable as a block.
static_assert(is_plain<PolarSpline>() && is_plain<ScanPoint>() && is_plain<LadarPoint>());

static_assert(wire_size<GetDataRequest>() == 4);
static_assert(wire_size<GetContDataRequest>() == 8);
static_assert(wire_size<ContDataReply>() == 4);
static_assert(wire_size<StopContDataRequest>() == 4);
static_assert(wire_size<Parameter>() == 172);
static_assert(wire_size<ParameterList>() == 4);
static_assert(wire_size<RuntimeData>() == 52);
static_assert(wire_size<RuntimePlace>() == 212);
static_assert(wire_size<ListenersData>() == 16);
static_assert(wire_size<ParameterEffects>() == 4);
static_assert(wire_size<ParameterEffect>() == 84);
static_assert(wire_size<ListenerInfo>() == 12);
static_assert(wire_size<DescriptionRequest>() == 8);
static_assert(wire_size<DescriptionPage>() == 12);

static_assert(wire_size<ChassisData>() == 36 && is_plain<ChassisData>());
static_assert(wire_size<ChassisMoveData>() == 12);
static_assert(wire_size<ChassisSetActivePilotData>() == 4);
static_assert(wire_size<ChassisParamData>() == 88);

static_assert(wire_size<CameraData>() == 16);
static_assert(body_max<CameraData>() == 3932176);
static_assert(wire_size<CameraParamData>() == 108);
static_assert(wire_size<CameraFormatData>() == 16);

static_assert(wire_size<ClockData>() == 48);

static_assert(wire_size<CompassData>() == 12);

static_assert(wire_size<WorldData>() == 12);
static_assert(wire_size<WorldThing>() == 96);
static_assert(wire_size<WorldObstacle>() == 20);
static_assert(wire_size<WorldLine>() == 228);

static_assert(wire_size<DatalogData>() == 48);
static_assert(wire_size<DatalogLogInfo>() == 64);
static_assert(wire_size<DatalogData>() + elements_max<DatalogData>() == DatalogData::kWholeSize);
static_assert(body_max<DatalogData>() == 6448);

static_assert(wire_size<FeatureMapData>() == 32);
static_assert(wire_size<FeatureMapDataPoint>() == 72 && is_plain<FeatureMapDataPoint>());
static_assert(wire_size<FeatureMapFeature>() == 80);
static_assert(wire_size<FeatureMapLayerData>() == 4);
static_assert(wire_size<FileName>() == 4);
static_assert(body_max<FileName>() == 132);

static_assert(wire_size<GdosData>() == 16);
static_assert(wire_size<GdosLogAddress>() == 8);
static_assert(wire_size<GdosTexts>() == 4);

static_assert(wire_size<GpsData>() == 100);

static_assert(wire_size<GridMapData>() == 24);
static_assert(body_max<GridMapData>() == 250024);

static_assert(wire_size<GyroData>() == 40);

static_assert(wire_size<IoData>() == 8);

static_assert(wire_size<JoystickData>() == 32);

static_assert(wire_size<LadarData>() == 24);
static_assert(wire_size<LadarPoint>() == 16);

static_assert(wire_size<MclData>() == 32);
static_assert(wire_size<MclDataPoint>() == 20 && is_plain<MclDataPoint>());

static_assert(wire_size<ObjRecogData>() == 56);
static_assert(wire_size<ObjRecogObject>() == 136 && is_plain<ObjRecogObject>());

static_assert(wire_size<OdometryData>() == 28);

static_assert(wire_size<PathData>() == 8);
static_assert(body_max<PathData>() == 744008);
static_assert(wire_size<PathMakeData>() == 16);
static_assert(wire_size<PathReplanData>() == 24);
static_assert(wire_size<PathDestData>() == 20);
static_assert(wire_size<PathRddfData>() == 4);
static_assert(wire_size<PathLayerData>() == 4);

static_assert(wire_size<PilotData>() == 72);
static_assert(wire_size<PilotStatusData>() == 68);
static_assert(wire_size<PilotDestData>() == 28);
static_assert(wire_size<PilotHoldData>() == 32);
static_assert(wire_size<PilotRevertData>() == 4);
static_assert(wire_size<PilotWatchdogData>() == 4);
static_assert(wire_size<PilotMultiDestData>() == 4);

static_assert(wire_size<PlannerString>() == 84);
static_assert(wire_size<PlannerData>() + elements_max<PlannerData>() == 4212);
static_assert(body_max<PlannerData>() == 4212);
static_assert(wire_size<PlannerCommand>() + elements_max<PlannerCommand>() == 4204);
static_assert(body_max<PlannerCommand>() == 4204);

static_assert(wire_size<PositionData>() == 52);
static_assert(wire_size<PositionWgs84Data>() == 24);
static_assert(wire_size<PositionGkData>() == 24);
static_assert(wire_size<PositionUtmData>() == 32);

static_assert(wire_size<PtzDriveData>() == 16);
static_assert(wire_size<PtzDriveMovePosData>() == 40);
static_assert(wire_size<PtzDriveMoveVelData>() == 12);

static_assert(wire_size<Scan2dData>() == 48);
static_assert(body_max<Scan2dData>() == 160048);

static_assert(wire_size<Scan3dData>() == 68);
static_assert(wire_size<Scan3dRangeImageData>() == 16);
static_assert(wire_size<RangePixel>() == 4 && is_plain<RangePixel>());

static_assert(wire_size<ServoDriveData>() == 8);
static_assert(wire_size<ServoDriveMovePosData>() == 16);
static_assert(wire_size<ServoDriveMoveVelData>() == 4);

static_assert(wire_size<VehicleData>() == 48);
static_assert(wire_size<VehicleSetValueData>() == 36);

}  // namespace
}  // namespace rack
