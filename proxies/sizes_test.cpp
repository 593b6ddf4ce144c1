// Every struct has the size that the specification's tables give (section 9).
#include "proxies/chassis.h"
#include "proxies/clock.h"
#include "proxies/datalog.h"
#include "proxies/joystick.h"
#include "proxies/ladar.h"
#include "proxies/odometry.h"
#include "proxies/pilot.h"
#include "proxies/position.h"
#include "proxies/scan2d.h"

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
// What is sent by the thousand is copied as a whole.
static_assert(is_plain<PolarSpline>() && is_plain<ScanPoint>() && is_plain<LadarPoint>());

static_assert(wire_size<GetDataRequest>() == 4);
static_assert(wire_size<GetContDataRequest>() == 8);
static_assert(wire_size<ContDataReply>() == 4);
static_assert(wire_size<StopContDataRequest>() == 4);
static_assert(wire_size<Parameter>() == 172);
static_assert(wire_size<ParameterList>() == 4);

static_assert(wire_size<ChassisData>() == 36 && is_plain<ChassisData>());
static_assert(wire_size<ChassisMoveData>() == 12);
static_assert(wire_size<ChassisSetActivePilotData>() == 4);
static_assert(wire_size<ChassisParamData>() == 88);

static_assert(wire_size<ClockData>() == 48);

static_assert(wire_size<DatalogData>() == 48);
static_assert(wire_size<DatalogLogInfo>() == 64);
static_assert(body_max<DatalogData>() == DatalogData::kWholeSize);

static_assert(wire_size<JoystickData>() == 32);

static_assert(wire_size<LadarData>() == 24);
static_assert(wire_size<LadarPoint>() == 16);

static_assert(wire_size<OdometryData>() == 28);

static_assert(wire_size<PilotData>() == 72);
static_assert(wire_size<PilotStatusData>() == 68);
static_assert(wire_size<PilotDestData>() == 28);
static_assert(wire_size<PilotHoldData>() == 32);
static_assert(wire_size<PilotRevertData>() == 4);
static_assert(wire_size<PilotMultiDestData>() == 4);

static_assert(wire_size<PositionData>() == 52);
static_assert(wire_size<PositionWgs84Data>() == 24);
static_assert(wire_size<PositionGkData>() == 24);
static_assert(wire_size<PositionUtmData>() == 32);

static_assert(wire_size<Scan2dData>() == 48);
static_assert(body_max<Scan2dData>() == 160048);

}  // namespace
}  // namespace rack
