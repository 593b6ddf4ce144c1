#include "proxies/body_info.h"
#include "proxies/catalogue_tables.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/gdos_log.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/planner.h"
#include "rack/proxies/position.h"

namespace rack {

namespace {

using namespace tims::class_id;
constexpr i8 kData = tims::type::kData;

constexpr MessageInfo kMessages[] = {
    {kDatalog, kData, "DATA", kBody<DatalogData>},
    {kDatalog, DatalogType::kInitLog, "INIT_LOG"},
    {kDatalog, DatalogType::kSetLog, "SET_LOG", kBody<DatalogData>},
    {kDatalog, DatalogType::kGetLogStatus, "GET_LOG_STATUS"},
    {kDatalog, DatalogType::kLogStatus, "LOG_STATUS", kBody<DatalogData>},

    {kGdos, kData, "DATA", kBody<GdosData>},
    {kGdos, GdosLogType::kGetLog, "GET_LOG"},
    {kGdos, GdosLogType::kLog, "LOG", kBody<GdosLogAddress>},

    {kOdometry, kData, "DATA", kBody<OdometryData>},
    {kOdometry, OdometryType::kReset, "RESET"},

    {kPath, kData, "DATA", kBody<PathData>},
    {kPath, PathType::kMake, "MAKE", kBody<PathMakeData>},
    {kPath, PathType::kReplan, "REPLAN", kBody<PathReplanData>},
    {kPath, PathType::kSetDestination, "SET_DESTINATION", kBody<PathDestData>},
    {kPath, PathType::kSetRddf, "SET_RDDF", kBody<PathRddfData>},
    {kPath, PathType::kGetDbgGridmap, "GET_DBG_GRIDMAP"},
    {kPath, PathType::kGetLayer, "GET_LAYER"},
    {kPath, PathType::kSetLayer, "SET_LAYER", kBody<PathLayerData>},
    {kPath, PathType::kDbgGridmap, "DBG_GRIDMAP"},
    {kPath, PathType::kLayer, "LAYER", kBody<PathLayerData>},
    {kPath, PathType::kLayerOfC, "LAYER", kBody<PathLayerData>},

    {kPilot, kData, "DATA", kBody<PilotData>},
    {kPilot, PilotType::kSetDestination, "SET_DESTINATION", kBody<PilotDestData>},
    {kPilot, PilotType::kHoldCommand, "HOLD_COMMAND", kBody<PilotHoldData>},
    {kPilot, PilotType::kRevertCommand, "REVERT_COMMAND", kBody<PilotRevertData>},
    {kPilot, PilotType::kGetStatus, "GET_STATUS"},
    {kPilot, PilotType::kStatus, "STATUS", kBody<PilotStatusData>},
    {kPilot, PilotType::kSetMultiDestination, "SET_MULTI_DESTINATION", kBody<PilotMultiDestData>},

    {kPlanner, kData, "DATA", kBody<PlannerData>},
    {kPlanner, PlannerType::kCommand, "COMMAND", kBody<PlannerCommand>},
    {kPlanner, PlannerType::kGetCommand, "GET_COMMAND"},

    {kPosition, kData, "DATA", kBody<PositionData>},
    {kPosition, PositionType::kUpdate, "UPDATE", kBody<PositionData>},
    {kPosition, PositionType::kWgs84ToPos, "WGS84_TO_POS", kBody<PositionWgs84Data>},
    {kPosition, PositionType::kPosToWgs84, "POS_TO_WGS84", kBody<PositionData>},
    {kPosition, PositionType::kGkToPos, "GK_TO_POS", kBody<PositionGkData>},
    {kPosition, PositionType::kPosToGk, "POS_TO_GK", kBody<PositionData>},
    {kPosition, PositionType::kUtmToPos, "UTM_TO_POS", kBody<PositionUtmData>},
    {kPosition, PositionType::kPosToUtm, "POS_TO_UTM", kBody<PositionData>},
    {kPosition, PositionType::kPos, "POS", kBody<PositionData>},
    {kPosition, PositionType::kWgs84, "WGS84", kBody<PositionWgs84Data>},
    {kPosition, PositionType::kGk, "GK", kBody<PositionGkData>},
    {kPosition, PositionType::kUtm, "UTM", kBody<PositionUtmData>},
};

}  // namespace

std::span<const MessageInfo> navigation_messages() { return kMessages; }

}  // namespace rack
