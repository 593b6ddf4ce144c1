#include "components/datalog/record_format.h"

#include <array>

#include "components/datalog/record_line.h"
#include "proxies/camera.h"
#include "proxies/chassis.h"
#include "proxies/clock.h"
#include "proxies/compass.h"
#include "proxies/gps.h"
#include "proxies/grid_map.h"
#include "proxies/gyro.h"
#include "proxies/io.h"
#include "proxies/ladar.h"
#include "proxies/mcl.h"
#include "proxies/obj_recog.h"
#include "proxies/odometry.h"
#include "proxies/path.h"
#include "proxies/pilot.h"
#include "proxies/position.h"
#include "proxies/scan2d.h"
#include "proxies/scan3d.h"
#include "proxies/servo_drive.h"
#include "proxies/vehicle.h"

namespace rack::datalog {
namespace {

using tims::MessageView;
using tims::Result;

template <typename Bytes>
std::string text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <typename... Fields>
void add_fields(RecordLine& line, const Fields&... fields) {
  (line.add(fields), ...);
}

// --- how a message is written: all of its fields, unless there is a function for it

template <Struct Data>
Record record_of(const Data& data, u32 /*file_number*/, bool /*binary_io*/) {
  RecordLine line;
  line.add(data);
  line.end();
  return {.line = line.take()};
}

Record record_of(const CameraData& data, u32 file_number, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.width, data.height, data.depth, data.mode,
             data.colorFilterId, file_number);
  line.end();
  return {.line = line.take(),
          .suffix = data.mode == camera_mode::kJpeg ? ".jpg" : ".raw",
          .file = text_of(data.image)};
}

Record record_of(const IoData& data, u32 file_number, bool binary_io) {
  if (!binary_io) return record_of<IoData>(data, file_number, binary_io);
  RecordLine line;
  const auto count = static_cast<u32>(data.values.size());
  add_fields(line, data.recordingTime, count, file_number);
  line.end();
  std::string raw(encoded_size(data), '\0');
  (void)encode(data, std::as_writable_bytes(std::span(raw)));
  return {.line = line.take(), .suffix = ".raw", .file = std::move(raw)};
}

Record record_of(const GridMapData& data, u32 file_number, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.offsetX, data.offsetY, data.scale, data.gridNumX,
             data.gridNumY, file_number);
  line.end();
  return {.line = line.take(), .suffix = ".raw", .file = text_of(data.occupancy)};
}

Record record_of(const MclData& data, u32 /*file_number*/, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.pos, data.points.size());
  for (const auto& point : data.points) add_fields(line, point.x, point.y, point.z, point.type);
  line.end();
  return {.line = line.take()};
}

Record record_of(const PathData& data, u32 /*file_number*/, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.splines.size());
  for (const PolarSpline& s : data.splines) {
    const Waypoint2d& to = s.basepoint;  // without its layer and actions
    add_fields(line, to.x, to.y, to.speed, to.maxRadius, to.type, to.request, to.lbo, to.id,
               to.wayId, s.startPos, s.endPos, s.centerPos, s.length, s.radius, s.vMax, s.vStart,
               s.vEnd, s.accMax, s.decMax, s.type, s.request, s.lbo);
  }
  line.end();
  return {.line = line.take()};
}

Record record_of(const PilotData& data, u32 /*file_number*/, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.pos, data.dest, data.speed, data.curve,
             data.distanceToDest, data.splines.size(), data.splines);
  line.end();
  return {.line = line.take()};
}

template <typename Points>
std::string point_lines(const Points& points) {
  RecordLine lines;
  for (const auto& point : points) {
    lines.add(point);
    lines.end();
  }
  return lines.take();
}

Record record_of(const Scan2dData& data, u32 file_number, bool /*binary_io*/) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.duration, data.maxRange, data.sectorNum,
             data.sectorIndex, data.refPos, data.points.size(), file_number);
  line.end();
  return {.line = line.take(), .suffix = ".2d", .file = point_lines(data.points)};
}

Record record_of(const Scan3dData& data, u32 file_number, bool binary_io) {
  RecordLine line;
  add_fields(line, data.recordingTime, data.duration, data.maxRange, data.scanNum,
             data.scanPointNum, data.scanMode, data.scanHardware, data.sectorNum, data.sectorIndex,
             data.refPos, data.pointNum, file_number);
  line.end();
  Record record{.line = line.take(), .suffix = ".3d", .file = point_lines(data.points)};
  if (binary_io) {
    record.raw_suffix = ".3d.raw";
    record.raw.resize(encoded_size(data));
    (void)encode(data, std::as_writable_bytes(std::span(record.raw)));
  }
  return record;
}

template <Struct Data>
Result<Record> record(const MessageView& message, u32 file_number, bool binary_io) {
  const auto data = decode<Data>(message);
  if (!data) return data.error();
  return record_of(*data, file_number, binary_io);
}

// --- the list

#define POSITION(name) name ".x " name ".y " name ".z " name ".phi " name ".psi " name ".rho"

template <Struct Data>
constexpr RecordedClass entry(std::uint32_t class_id, std::string_view name, std::int32_t instances,
                              std::string_view columns) {
  return {class_id, name, instances, body_max<Data>(), columns, &record<Data>};
}

namespace id = tims::class_id;

constexpr std::array<RecordedClass, 19> kClasses = {{
    entry<CameraData>(id::kCamera, "camera", 4,
                      "recordingTime width height depth mode colorFilterId fileNum"),
    entry<ChassisData>(id::kChassis, "chassis", 1,
                       "recordingTime deltaX deltaY deltaRho vx vy omega battery activePilot"),
    // As the original writes it, which has forgotten the minute.
    entry<ClockData>(id::kClock, "clock", 3,
                     "recordingTime hour second day month year utcTime dayOfWeek syncMode varT"),
    entry<CompassData>(id::kCompass, "compass", 1, "recordingTime orientation varOrientation"),
    entry<GpsData>(id::kGps, "gps", 4,
                   "recordingTime mode latitude longitude altitude heading speed satelliteNum "
                   "utcTime pdop " POSITION("pos") " " POSITION("var")),
    entry<GyroData>(id::kGyro, "gyro", 2,
                    "recordingTime roll pitch yaw aX aY aZ wRoll wPitch wYaw"),
    entry<IoData>(id::kIo, "io", 2, "recordingTime valueNum value..."),
    entry<LadarData>(id::kLadar, "ladar", 4,
                     "recordingTime duration maxRange startAngle endAngle pointNum "
                     "(angle distance type intensity)..."),
    entry<ServoDriveData>(id::kServoDrive, "servodrive", 5, "recordingTime position"),
    entry<VehicleData>(id::kVehicle, "vehicle", 1,
                       "recordingTime speed omega throttle brake clutch steering gear engine "
                       "parkBrake vehicleProtect activeController"),
    entry<OdometryData>(id::kOdometry, "odometry", 3, "recordingTime " POSITION("pos")),
    entry<GridMapData>(id::kGridMap, "gridmap", 2,
                       "recordingTime offsetX offsetY scale gridNumX gridNumY fileNum"),
    entry<MclData>(id::kMcl, "mcl", 5,
                   "recordingTime " POSITION("pos") " pointNum (x y z type)..."),
    entry<PathData>(id::kPath, "path", 2,
                    "recordingTime splineNum (x y speed maxRadius type request lbo id wayId "
                    "startPos.x startPos.y startPos.rho endPos.x endPos.y endPos.rho centerPos.x "
                    "centerPos.y centerPos.rho length radius vMax vStart vEnd accMax decMax type "
                    "request lbo)..."),
    entry<PilotData>(
        id::kPilot, "pilot", 3,
        "recordingTime " POSITION("pos") " " POSITION(
            "dest") " speed curve distanceToDest splineNum (x y speed maxRadius type request lbo "
                    "id wayId layer actionStart actionEnd startPos.x startPos.y startPos.rho "
                    "endPos.x endPos.y endPos.rho centerPos.x centerPos.y centerPos.rho length "
                    "radius vMax vStart vEnd accMax decMax type request lbo)..."),
    entry<PositionData>(id::kPosition, "position", 3,
                        "recordingTime " POSITION("pos") " " POSITION("var")),
    entry<ObjRecogData>(
        id::kObjRecog, "obj_recog", 6,
        "recordingTime " POSITION("refPos") " " POSITION(
            "varRefPos") " objectNum (objectId type pos varPos vel varVel dim prob imageArea)..."),
    entry<Scan2dData>(id::kScan2d, "scan2d", 9,
                      "recordingTime duration maxRange sectorNum sectorIndex " POSITION(
                          "refPos") " pointNum fileNum"),
    entry<Scan3dData>(id::kScan3d, "scan3d", 3,
                      "recordingTime duration maxRange scanNum scanPointNum scanMode scanHardware "
                      "sectorNum sectorIndex " POSITION("refPos") " pointNum fileNum"),
}};

#undef POSITION

}  // namespace

std::span<const RecordedClass> recorded_classes() { return kClasses; }

const RecordedClass* recorded_class(std::uint32_t class_id) {
  for (const RecordedClass& recorded : kClasses) {
    if (recorded.class_id == class_id) return &recorded;
  }
  return nullptr;
}

std::string heading(const RecordedClass& recorded, tims::Address module,
                    const tims::AddressWidths& widths) {
  return "% " + module.to_string(widths) + "\n% " + std::string(recorded.columns) + "\n";
}

}  // namespace rack::datalog
