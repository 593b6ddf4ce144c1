#include "components/datalog/record_format.h"

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "base/text.h"
#include "rack/codec/message_text.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/catalogue.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/compass.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/gyro.h"
#include "rack/proxies/io.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d.h"
#include "rack/proxies/scan3d_compression.h"
#include "rack/proxies/servo_drive.h"
#include "rack/proxies/vehicle.h"

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

// --- formatting of a message: all of its fields, unless there is a special function

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
  if (data.compressed !=
      0) {  // files contain points; invalid compressed data are recorded without points
    Scan3dData scan = data;
    if (!Scan3dCompression().decompress(scan)) {
      scan.compressed = 0;
      scan.pointNum = 0;
      scan.compressedPoints.clear();
    }
    return record_of(scan, file_number, binary_io);
  }
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

// The fields of a spline between its waypoint and its end.
#define SPLINE                                                                           \
  "spline[0].startPos.x spline[0].startPos.y spline[0].startPos.rho spline[0].endPos.x " \
  "spline[0].endPos.y spline[0].endPos.rho spline[0].centerPos.x spline[0].centerPos.y " \
  "spline[0].centerPos.rho spline[0].length spline[0].radius spline[0].vMax "            \
  "spline[0].vStart spline[0].vEnd spline[0].accMax spline[0].decMax spline[0].type "    \
  "spline[0].request spline[0].lbo"
#define BASEPOINT                                                                       \
  "spline[0].basepoint.x spline[0].basepoint.y spline[0].basepoint.speed "              \
  "spline[0].basepoint.maxRadius spline[0].basepoint.type spline[0].basepoint.request " \
  "spline[0].basepoint.lbo spline[0].basepoint.id spline[0].basepoint.wayId"

template <Struct Data>
constexpr RecordedClass entry(std::uint32_t class_id, std::string_view title, std::string_view name,
                              std::int32_t instances, std::string_view columns) {
  return {class_id, title, name, instances, body_max<Data>(), columns, &record<Data>};
}

namespace id = tims::class_id;

// Columns as the original writes them: of a sequence only the first element, and without the fields
// that the original omits (minute of the clock, engine of the vehicle, variances of recognised
// objects).
constexpr std::array<RecordedClass, 19> kClasses = {{
    entry<CameraData>(id::kCamera, "Camera", "camera", 4,
                      "recordingTime width height depth mode colorFilterId cameraFileNum"),
    entry<ChassisData>(id::kChassis, "Chassis", "chassis", 1,
                       "recordingTime deltaX deltaY deltaRho vx vy omega battery activePilot"),
    entry<ClockData>(id::kClock, "Clock", "clock", 3,
                     "recordingTime hour second day month year utcTime dayOfWeek syncMode varT"),
    entry<CompassData>(id::kCompass, "Compass", "compass", 1,
                       "recordingTime orientation varOrientation"),
    entry<GpsData>(id::kGps, "Gps", "gps", 4,
                   "recordingTime mode latitude longitude altitude heading speed satelliteNum "
                   "utcTime pdop " POSITION("pos") " " POSITION("var")),
    entry<GyroData>(id::kGyro, "Gyro", "gyro", 2,
                    "recordingTime roll pitch yaw aX aY aZ wRoll wPitch wYaw"),
    entry<IoData>(id::kIo, "Io", "io", 2, "recordingTime valueNum value[0] "),
    entry<LadarData>(id::kLadar, "Ladar", "ladar", 4,
                     "recordingTime duration maxRange startAngle endAngle pointNum point[0].angle "
                     "point[0].distance point[0].type point[0].intensity"),
    entry<ServoDriveData>(id::kServoDrive, "Servodrive", "servodrive", 5, "recordingTime position"),
    entry<VehicleData>(id::kVehicle, "Vehicle", "vehicle", 1,
                       "recordingTime speed omega throttle brake clutch steering gear parkBrake "
                       "vehicleProtect activeController"),
    entry<OdometryData>(id::kOdometry, "Odometry", "odometry", 3, "recordingTime " POSITION("pos")),
    entry<GridMapData>(id::kGridMap, "Gridmap", "gridmap", 2,
                       "recordingTime offsetX offsetY scale gridNumX gridNumY gridMapFileNum"),
    entry<MclData>(id::kMcl, "Mcl", "mcl", 5,
                   "recordingTime " POSITION(
                       "pos") " pointNum point[0].x point[0].y point[0].z point[0].type"),
    entry<PathData>(id::kPath, "Path", "path", 2, "recordingTime splineNum " BASEPOINT " " SPLINE),
    entry<PilotData>(id::kPilot, "Pilot", "pilot", 3,
                     "recordingTime " POSITION("pos") " " POSITION(
                         "dest") " speed curve distanceToDest splineNum " BASEPOINT
                                 " spline[0].basepoint.layer spline[0].basepoint.actionStart "
                                 "spline[0].basepoint.actionEnd " SPLINE),
    entry<PositionData>(id::kPosition, "Position", "position", 3,
                        "recordingTime " POSITION("pos") " " POSITION("var")),
    entry<ObjRecogData>(
        id::kObjRecog, "ObjRecog", "obj_recog", 6,
        "recordingTime " POSITION("refPos") " objectNum object[0].objectId " POSITION(
            "object[0].pos") "  " POSITION("object[0].vel") " object[0].dim.x object[0].dim.y "
                                                            "object[0].dim.z object[0].prob "
                                                            "object[0].imageArea.x "
                                                            "object[0].imageArea.y "
                                                            "object[0].imageArea.width "
                                                            "object[0].imageArea.height"),
    entry<Scan2dData>(id::kScan2d, "Scan2d", "scan2d", 9,
                      "recordingTime duration maxRange sectorNum sectorIndex " POSITION(
                          "refPos") " pointNum scan2dFileNum"),
    entry<Scan3dData>(id::kScan3d, "Scan3d", "scan3d", 3,
                      "recordingTime duration maxRange scanNum scanPointNum scanMode scanHardware "
                      "sectorNum sectorIndex " POSITION("refPos") " pointNum scan3dFileNum"),
}};

#undef BASEPOINT
#undef SPLINE
#undef POSITION

// The names of the fields; for a sequence those of its first element.
std::string column_names(const Schema& data) {
  std::string columns;
  for (const Column& column : columns_of(data)) {
    std::string name = column.name;
    if (const std::size_t all = name.find("[]"); all != std::string::npos)
      name.replace(all, 2, "[0]");
    columns.append(columns.empty() ? "" : " ").append(name);
  }
  return columns;
}

std::vector<RecordedClass> with_added() {
  static std::deque<std::string> texts;  // storage of the texts in the list
  std::vector<RecordedClass> all(kClasses.begin(), kClasses.end());
  for (const ClassInfo& own : added_classes()) {
    const MessageInfo* data = find_message(own.class_id, tims::type::kData);
    if (data == nullptr || data->body == nullptr) continue;
    const std::string& name = texts.emplace_back(tims::base::lower(own.name));
    all.push_back({own.class_id, own.name, name, 1, data->body->size_max,
                   texts.emplace_back(column_names(*data->body)), nullptr, data->body});
  }
  return all;
}

constexpr std::size_t kListMax = 100;

tims::Error bad(std::size_t line, std::string_view what) {
  return {tims::Errc::kMalformed, "line " + std::to_string(line) + ": " + std::string(what)};
}

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// "00140000", "0x00140000" or "Ladar(0/0)".
tims::Result<tims::Address> module_address(std::string_view text,
                                           const tims::AddressWidths& widths) {
  std::string_view digits = text;
  if (digits.starts_with("0x")) digits.remove_prefix(2);
  if (const auto raw = tims::base::parse_number<u32>(digits, 16)) return tims::Address(*raw);
  if (const auto address = tims::Address::parse(text, widths)) return *address;
  const std::string why = tims::Address::problem(text, widths);
  return tims::Error(tims::Errc::kInvalidArgument,
                     why.empty() ? "the address is neither a hexadecimal number nor a name such as "
                                   "Ladar(0/0)"
                                 : why);
}

tims::Result<DatalogLogInfo> read_entry(std::string_view line, std::size_t number,
                                        const tims::AddressWidths& widths) {
  const auto blank = line.find(' ');
  if (blank == std::string_view::npos || blank + 1 == line.size())
    return bad(number, "expected an address, a blank and a file name");
  const auto address = module_address(line.substr(0, blank), widths);
  if (!address) return bad(number, address.error().detail());
  auto recorded = log_info(*address, widths);
  if (!recorded) return bad(number, recorded.error().detail());
  DatalogLogInfo info = *recorded;
  if (!info.filename.assign(line.substr(blank + 1)))
    return bad(number, "the file name is longer than 39 characters");
  return info;
}

}  // namespace

std::span<const RecordedClass> recorded_classes() {
  static const std::vector<RecordedClass> all = with_added();
  return all;
}

Result<Record> record(const RecordedClass& recorded, const MessageView& message, u32 file_number,
                      bool binary_io) {
  if (recorded.record != nullptr) return recorded.record(message, file_number, binary_io);
  const auto value = read_value(*recorded.data, message.body, message.header.body_order());
  if (!value) return value.error();
  return Record{.line = to_numbers(*recorded.data, *value) + "\n"};
}

const RecordedClass* recorded_class(std::uint32_t class_id) {
  for (const RecordedClass& recorded : recorded_classes()) {
    if (recorded.class_id == class_id) return &recorded;
  }
  return nullptr;
}

std::string heading(const RecordedClass& recorded, tims::Address module,
                    const tims::AddressWidths& widths) {
  const auto [system, class_id, instance, local] = module.fields(widths);
  return "% " + std::string(recorded.title) + "(" + std::to_string(system) + "/" +
         std::to_string(instance) + ")\n% " + std::string(recorded.columns) + "\n";
}

tims::Result<DatalogLogInfo> log_info(tims::Address module, const tims::AddressWidths& widths) {
  const auto fields = module.fields(widths);
  const RecordedClass* recorded = recorded_class(fields.class_id);
  if (recorded == nullptr) {
    const std::string_view name = tims::class_name(fields.class_id);
    return tims::Error(tims::Errc::kInvalidArgument,
                       "data of class " +
                           (name.empty() ? class_number(fields.class_id) : std::string(name)) +
                           " are not recorded");
  }
  DatalogLogInfo info{.moduleMbx = module, .maxDataLen = static_cast<i32>(recorded->body_max)};
  const std::string system = fields.system == 0 ? "" : std::to_string(fields.system) + "_";
  (void)info.filename.assign(std::string(recorded->name) + "_" + system +
                             std::to_string(fields.instance) + ".dat");
  return info;
}

tims::Result<std::vector<DatalogLogInfo>> modules_of(std::string_view text,
                                                     const tims::AddressWidths& widths) {
  std::vector<DatalogLogInfo> list;
  constexpr std::string_view kBetween = " ,\t";
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBetween), text.size()));
    if (text.empty()) return list;
    const std::string_view name = text.substr(0, text.find_first_of(kBetween));
    text.remove_prefix(name.size());
    const auto address = module_address(name, widths);
    if (!address)
      return tims::Error(address.error().code(),
                         std::string(name) + ": " + address.error().detail());
    auto info = log_info(*address, widths);
    if (!info) return info.error();
    if (list.size() == kListMax)
      return tims::Error(tims::Errc::kInvalidArgument, "more than 100 modules");
    list.push_back(*info);
  }
}

tims::Result<void> change_list(DatalogData& list, const DatalogData& wanted,
                               const tims::AddressWidths& widths) {
  std::vector<DatalogLogInfo> changed(list.logInfo.begin(), list.logInfo.end());
  for (const DatalogLogInfo& one : wanted.logInfo) {
    auto entry = std::ranges::find(changed, one.moduleMbx, &DatalogLogInfo::moduleMbx);
    if (entry == changed.end()) {
      const auto info = log_info(one.moduleMbx, widths);
      if (!info) return info.error();
      if (changed.size() == kListMax)
        return tims::Error(tims::Errc::kInvalidArgument,
                           "the list has 100 modules already: shorten it with INIT_LOG");
      entry = changed.insert(changed.end(), *info);
    }
    entry->logEnable = one.logEnable;
    entry->periodTime = one.periodTime;
    if (!one.filename.view().empty()) entry->filename = one.filename;
  }
  list.logInfo.assign(changed.begin(), changed.end());
  return {};
}

tims::Result<std::vector<DatalogLogInfo>> read_list(std::string_view text,
                                                    const tims::AddressWidths& widths) {
  std::vector<DatalogLogInfo> list;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    if (line.empty()) break;
    const auto entry = read_entry(line, number, widths);
    if (!entry) return entry.error();
    if (list.size() == kListMax) return bad(number, "more than 100 modules");
    list.push_back(*entry);
  }
  return list;
}

std::string base_of(const std::string& path) {
  const auto name = path.rfind('/') + 1;  // also correct when there is no slash
  const auto dot = path.rfind('.');
  return dot == std::string::npos || dot < name ? path : path.substr(0, dot);
}

}  // namespace rack::datalog
