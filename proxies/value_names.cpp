#include "proxies/value_names.h"

#include "rack/proxies/camera.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/gdos.h"
#include "rack/proxies/generic.h"
#include "rack/proxies/geometry.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/scan3d.h"
#include "rack/proxies/world.h"

namespace rack {
namespace {

constexpr ValueName kParameterTypes[] = {
    {"int", Parameter::kInt}, {"text", Parameter::kString}, {"float", Parameter::kFloat}};
constexpr ValueName kTakesEffect[] = {{"now", static_cast<i64>(TakesEffect::kNow)},
                                      {"at ON", static_cast<i64>(TakesEffect::kAtOn)},
                                      {"at start", static_cast<i64>(TakesEffect::kAtStart)}};
constexpr ValueName kWatchDepths[] = {{"off", static_cast<i64>(WatchDepth::kOff)},
                                      {"counts", static_cast<i64>(WatchDepth::kCounts)},
                                      {"fault places", static_cast<i64>(WatchDepth::kFaultPlaces)},
                                      {"all places", static_cast<i64>(WatchDepth::kAllPlaces)}};
constexpr ValueName kPlaceKinds[] = {{"blocked", RuntimePlace::kBlocked},
                                     {"page fault", RuntimePlace::kPageFault}};
constexpr ValueName kLevels[] = {{"print", static_cast<i64>(gdos::Level::kPrint)},
                                 {"error", static_cast<i64>(gdos::Level::kError)},
                                 {"warning", static_cast<i64>(gdos::Level::kWarning)},
                                 {"info", static_cast<i64>(gdos::Level::kInfo)},
                                 {"detail", static_cast<i64>(gdos::Level::kDetail)}};

constexpr ValueName kCameraModes[] = {{"mono8", camera_mode::kMono8},
                                      {"mono12", camera_mode::kMono12},
                                      {"mono16", camera_mode::kMono16},
                                      {"mono24", camera_mode::kMono24},
                                      {"rgb24", camera_mode::kRgb24},
                                      {"rgb565", camera_mode::kRgb565},
                                      {"yuv422", camera_mode::kYuv422},
                                      {"raw8", camera_mode::kRaw8},
                                      {"raw12", camera_mode::kRaw12},
                                      {"raw16", camera_mode::kRaw16},
                                      {"jpeg", camera_mode::kJpeg},
                                      {"range", camera_mode::kRange},
                                      {"intensity", camera_mode::kIntensity},
                                      {"type and intensity", camera_mode::kTypeIntensity},
                                      {"range and type", camera_mode::kRangeType},
                                      {"segment", camera_mode::kSegment},
                                      {"elevation", camera_mode::kElevation},
                                      {"type", camera_mode::kType},
                                      {"edge", camera_mode::kEdge},
                                      {"disparity", camera_mode::kDisparity}};
constexpr ValueName kGpsModes[] = {
    {"invalid", gps_mode::kInvalid}, {"2D", gps_mode::k2d}, {"3D", gps_mode::k3d}};
constexpr ValueName kGpsFlags[] = {{"differential", gps_mode::kDifferential},
                                   {"estimated", gps_mode::kEstimated}};
constexpr ValueName kLadarTypes[] = {{"unknown", ladar_point::kUnknown},
                                     {"transparent", ladar_point::kTransparent},
                                     {"rain", ladar_point::kRain},
                                     {"dirt", ladar_point::kDirt}};
constexpr ValueName kLadarFlags[] = {{"invalid", ladar_point::kInvalid},
                                     {"reflector", ladar_point::kReflector}};
// The class of a point, which differs between scans of a plane and of space, has no name here.
constexpr ValueName kScanPointFlags[] = {{"invalid", scan_point::kInvalid},
                                         {"maximum range", scan_point::kMaxRange},
                                         {"reduce", scan_point::kReduce},
                                         {"reflector", scan_point::kReflector},
                                         {"horizontal edge", scan_point::kHorizontalEdge},
                                         {"edge", scan_point::kEdge}};
constexpr ValueName kScanModes[] = {{"roll", scan_mode::kRoll},
                                    {"pitch", scan_mode::kPitch},
                                    {"yaw", scan_mode::kYaw},
                                    {"top", scan_mode::kTop},
                                    {"top-down", scan_mode::kTopDown}};
constexpr ValueName kScanFlags[] = {{"positive turn", scan_mode::kPositiveTurn},
                                    {"square grid", scan_mode::kSquareGrid},
                                    {"start at 180", scan_mode::kStartAt180}};

constexpr ValueName kFeatures[] = {{"line", FeatureMapDataPoint::kLine}};
constexpr ValueName kMclPoints[] = {{"sample", mcl_point::kSample},
                                    {"measurement", mcl_point::kMeasurement},
                                    {"reflector", mcl_point::kReflector},
                                    {"line", mcl_point::kLine}};
constexpr ValueName kObjects[] = {{"unclassified", object_type::kUnclassified},
                                  {"small", object_type::kUnknownSmall},
                                  {"big", object_type::kUnknownBig},
                                  {"pedestrian", object_type::kPedestrian},
                                  {"bike", object_type::kBike},
                                  {"car", object_type::kCar},
                                  {"truck", object_type::kTruck}};
constexpr ValueName kPilotStates[] = {{"idle", pilot_state::kIdle},
                                      {"planning", pilot_state::kPlanning},
                                      {"running", pilot_state::kRunning},
                                      {"path error", pilot_state::kPathError}};
constexpr ValueName kWorldThings[] = {{"robot", world_thing::kRobot},
                                      {"person", world_thing::kPerson},
                                      {"obstacle", world_thing::kObstacle}};

constexpr FieldValues kFieldValues[] = {
    {"Parameter.type", kParameterTypes},
    {"ParameterEffect.takesEffect", kTakesEffect},
    {"RuntimeData.watch", kWatchDepths},
    {"RuntimePlace.kind", kPlaceKinds},
    {"GdosData.level", kLevels},
    {"CameraData.mode", kCameraModes},
    {"CameraFormatData.mode", kCameraModes},
    {"GpsData.mode", kGpsModes, kGpsFlags},
    {"LadarPoint.type", kLadarTypes, kLadarFlags},
    {"ScanPoint.type", {}, kScanPointFlags},
    {"Scan3dData.scanMode", kScanModes, kScanFlags},
    {"Scan3dRangeImageData.scanMode", kScanModes, kScanFlags},
    {"FeatureMapDataPoint.type", kFeatures},
    {"MclDataPoint.type", kMclPoints},
    {"ObjRecogObject.type", kObjects},
    {"PilotData.pilotState", kPilotStates},
    {"PilotStatusData.pilotState", kPilotStates},
    {"WorldThing.kind", kWorldThings},
};

}  // namespace

std::span<const FieldValues> field_values() { return kFieldValues; }

}  // namespace rack
