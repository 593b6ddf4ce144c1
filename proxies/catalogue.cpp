#include "rack/proxies/catalogue.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "base/text.h"
#include "proxies/struct_json.h"
#include "rack/codec/message_text.h"
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

using namespace tims::class_id;
namespace type = tims::type;
constexpr i8 kData = tims::type::kData;

static_assert(kNoPilot == kNobody);

constexpr MessageInfo kFramework[] = {
    {kEveryClass, type::kOk, "OK"},
    {kEveryClass, type::kError, "ERROR"},
    {kEveryClass, type::kTimeout, "TIMEOUT"},
    {kEveryClass, type::kNotAvailable, "NOT_AVAILABLE"},
    {kEveryClass, type::kEnabled, "ENABLED"},
    {kEveryClass, type::kDisabled, "DISABLED"},
    {kEveryClass, type::kContData, "CONT_DATA", kBody<ContDataReply>},
    {kEveryClass, type::kParam, "PARAM", kBody<ParameterList>},
    {kEveryClass, type::kParamEffects, "PARAM_EFFECTS", kBody<ParameterEffects>},
    {kEveryClass, type::kRuntime, "RUNTIME", kBody<RuntimeData>},
    {kEveryClass, type::kListeners, "LISTENERS", kBody<ListenersData>},
    {kEveryClass, type::kDescription, "DESCRIPTION", kBody<DescriptionPage>},
    {kEveryClass, type::kOn, "ON"},
    {kEveryClass, type::kOff, "OFF"},
    {kEveryClass, type::kGetStatus, "GET_STATUS"},
    {kEveryClass, type::kGetData, "GET_DATA", kBody<GetDataRequest>},
    {kEveryClass, type::kGetContData, "GET_CONT_DATA", kBody<GetContDataRequest>},
    {kEveryClass, type::kStopContData, "STOP_CONT_DATA", kBody<StopContDataRequest>},
    {kEveryClass, type::kGetNextData, "GET_NEXT_DATA"},
    {kEveryClass, type::kGetParam, "GET_PARAM"},
    {kEveryClass, type::kSetParam, "SET_PARAM", kBody<ParameterList>},
    {kEveryClass, type::kGetParamEffects, "GET_PARAM_EFFECTS"},
    {kEveryClass, type::kGetRuntime, "GET_RUNTIME"},
    {kEveryClass, type::kGetListeners, "GET_LISTENERS"},
    {kEveryClass, type::kGetDescription, "GET_DESCRIPTION", kBody<DescriptionRequest>},
};

// --- sensors and actuators

constexpr MessageInfo kDrivers[] = {
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

// --- maps, scans, objects

constexpr MessageInfo kPerception[] = {
    {kFeatureMap, kData, "DATA", kBody<FeatureMapData>},
    {kFeatureMap, FeatureMapType::kLoadMap, "LOAD_MAP", kBody<FileName>},
    {kFeatureMap, FeatureMapType::kAddLine, "ADD_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kSaveMap, "SAVE_MAP", kBody<FileName>},
    {kFeatureMap, FeatureMapType::kGiveMap, "GIVE_MAP"},
    {kFeatureMap, FeatureMapType::kDeleteLine, "DELETE_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kDisplaceLine, "DISPLACE_LINE", kBody<FeatureMapFeature>},
    {kFeatureMap, FeatureMapType::kGetLayer, "GET_LAYER"},
    {kFeatureMap, FeatureMapType::kSetLayer, "SET_LAYER", kBody<FeatureMapLayerData>},
    {kFeatureMap, FeatureMapType::kLayer, "LAYER", kBody<FeatureMapLayerData>},

    {kGridMap, kData, "DATA", kBody<GridMapData>},

    {kMcl, kData, "DATA", kBody<MclData>},
    {kMcl, MclType::kLoadMap, "LOAD_MAP", kBody<FileName>},

    {kObjRecog, kData, "DATA", kBody<ObjRecogData>},
    {kObjRecog, ObjRecogType::kSetEstimate, "SET_ESTIMATE", kBody<ObjRecogData>},
    {kObjRecog, ObjRecogType::kStopRecog, "STOP_RECOG", kBody<ObjRecogData>},

    {kScan2d, kData, "DATA", kBody<Scan2dData>},

    {kScan3d, kData, "DATA", kBody<Scan3dData>},
    {kScan3d, Scan3dType::kGetRangeImage, "GET_RANGE_IMAGE"},
    {kScan3d, Scan3dType::kStoreData, "STORE_DATA"},
    {kScan3d, Scan3dType::kRangeImage, "RANGE_IMAGE", kBody<Scan3dRangeImageData>},
};

// --- a simulated world

constexpr MessageInfo kSimulation[] = {
    {kWorld, kData, "DATA", kBody<WorldData>},
    {kWorld, WorldType::kPlace, "PLACE", kBody<WorldPlace>},
    {kWorld, WorldType::kPut, "PUT", kBody<WorldObstacle>},
    {kWorld, WorldType::kRemove, "REMOVE", kBody<WorldRemove>},
    {kWorld, WorldType::kPeople, "PEOPLE", kBody<WorldPeople>},
    {kWorld, WorldType::kPlug, "PLUG", kBody<WorldPlug>},
    {kWorld, WorldType::kGetLines, "GET_LINES"},
    {kWorld, WorldType::kObstacle, "OBSTACLE", kBody<WorldObstacle>},
    {kWorld, WorldType::kLines, "LINES", kBody<WorldLines>},
};

// --- position, path, pilot; datalog, planner

constexpr MessageInfo kNavigation[] = {
    {kDatalog, kData, "DATA", kBody<DatalogData>},
    {kDatalog, DatalogType::kInitLog, "INIT_LOG"},
    {kDatalog, DatalogType::kSetLog, "SET_LOG", kBody<DatalogData>},
    {kDatalog, DatalogType::kGetLogStatus, "GET_LOG_STATUS"},
    {kDatalog, DatalogType::kLogStatus, "LOG_STATUS", kBody<DatalogData>},

    {kGdos, kData, "DATA", kBody<GdosData>},
    {kGdos, GdosLogType::kGetLog, "GET_LOG"},
    {kGdos, GdosLogType::kLog, "LOG", kBody<GdosLogAddress>},
    {kGdos, GdosLogType::kGetTexts, "GET_TEXTS"},
    {kGdos, GdosLogType::kTexts, "TEXTS", kBody<GdosTexts>},

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
    {kPath, PathType::kDbgGridmap, "DBG_GRIDMAP", kBody<GridMapData>},
    {kPath, PathType::kLayer, "LAYER", kBody<PathLayerData>},
    {kPath, PathType::kLayerOfC, "LAYER", kBody<PathLayerData>},

    {kPilot, kData, "DATA", kBody<PilotData>},
    {kPilot, PilotType::kSetDestination, "SET_DESTINATION", kBody<PilotDestData>},
    {kPilot, PilotType::kHoldCommand, "HOLD_COMMAND", kBody<PilotHoldData>},
    {kPilot, PilotType::kRevertCommand, "REVERT_COMMAND", kBody<PilotRevertData>},
    {kPilot, PilotType::kWatchdog, "WATCHDOG", kBody<PilotWatchdogData>},
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

// Classes that RACK does not define; they are added before the program starts threads.
std::vector<ClassInfo>& classes() {
  static std::vector<ClassInfo> added;
  return added;
}

// Searches the messages of the class, then those of the framework.
template <typename Fits>
const MessageInfo* find(u32 class_id, const Fits& fits) {
  for (const u32 of_class : {class_id, kEveryClass}) {
    const auto same = [&](const MessageInfo& m) { return m.class_id == of_class && fits(m); };
    for (const std::span<const MessageInfo> table : {std::span<const MessageInfo>(kFramework),
                                                     {kDrivers},
                                                     {kPerception},
                                                     {kNavigation},
                                                     {kSimulation}}) {
      const auto found = std::ranges::find_if(table, same);
      if (found != table.end()) return &*found;
    }
    for (const ClassInfo& own : classes()) {
      const auto found = std::ranges::find_if(own.messages, same);
      if (found != own.messages.end()) return &*found;
    }
  }
  return nullptr;
}

}  // namespace

std::vector<std::span<const MessageInfo>> message_tables() {
  std::vector<std::span<const MessageInfo>> tables{kFramework, kDrivers, kPerception, kNavigation,
                                                   kSimulation};
  for (const ClassInfo& own : classes()) tables.push_back(own.messages);
  return tables;
}

Result<void> add_class(const ClassInfo& own) {
  const auto taken = [&](std::string_view by) {
    return tims::Error(tims::Errc::kAddressInUse,
                       "class " + class_number(own.class_id) + ", " + std::string(own.name) +
                           ": number or name is that of " + std::string(by));
  };
  for (const ClassInfo& other : classes())
    if (other.class_id == own.class_id && other.name == own.name) return {};  // added before
  if (!tims::name_class(own.class_id, own.name)) {
    const auto by = tims::class_name(own.class_id);
    return taken(by.empty() ? own.name : by);
  }
  classes().push_back(own);
  return {};
}

std::span<const ClassInfo> added_classes() { return classes(); }

std::string class_number(u32 class_id) {
  std::array<char, 8> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), class_id, 16).ptr;
  return std::to_string(class_id) + " (0x" + std::string(digits.data(), end) + ")";
}

const MessageInfo* find_message(u32 class_id, i8 type) {
  return find(class_id, [&](const MessageInfo& m) { return m.type == type; });
}

const MessageInfo* find_message(u32 class_id, std::string_view name) {
  const std::string wanted = tims::base::lower(name);
  return find(class_id, [&](const MessageInfo& m) { return tims::base::lower(m.name) == wanted; });
}

const MessageInfo* find_message(const tims::Header& header, const tims::AddressWidths& widths) {
  if (header.dest == tims::Address() && header.src == tims::Address()) return nullptr;
  const u32 sender = header.src.fields(widths).class_id;
  if (header.type <= 0) return find_message(sender, header.type);
  const MessageInfo* found = find_message(header.dest.fields(widths).class_id, header.type);
  // Some classes have replies with positive numbers.
  return found != nullptr ? found : find_message(sender, header.type);
}

// --- files of messages

namespace {

// Structs contained in it come first.
Result<void> append_structs(std::string& out, StructsThere& there, const Schema& schema) {
  if (const std::string tail = tail_in(schema); !tail.empty())
    return tims::Error(tims::Errc::kInvalidArgument,
                       tail + " is a Tail, whose length only a program knows: make it a Sequence");
  append_struct(out, there, schema);
  return {};
}

}  // namespace

Result<std::string> message_file(const ClassInfo& own) {
  std::string out = "{\n  \"rack_messages\": 1,\n  \"class\": ";
  append_quoted(out, own.name);
  out += ",\n  \"class_id\": " + std::to_string(own.class_id) + ",\n  \"structs\": [";
  StructsThere there;
  for (const MessageInfo& message : own.messages) {
    if (message.body == nullptr) continue;
    if (const auto good = append_structs(out, there, *message.body); !good) return good.error();
  }
  if (there.empty()) out.resize(out.rfind(",\n"));  // no empty list
  out += there.empty() ? ",\n  \"messages\": [" : "],\n  \"messages\": [";
  append_messages(out, own.messages, 4);
  return out += "]\n}\n";
}

}  // namespace rack
