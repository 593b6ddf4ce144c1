#include "components/datalog/record_format.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "rack/proxies/camera.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/io.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/scan3d.h"
#include "rack/proxies/scan3d_compression.h"

namespace rack::datalog {

namespace record_format_test {

template <Struct Data>
Record recorded(std::uint32_t class_id, const Data& data, bool binary_io = false) {
  std::vector<std::byte> body(encoded_size(data));
  EXPECT_TRUE(encode(data, body));
  auto record = recorded_class(class_id)->record({.header = {}, .body = body}, 3, binary_io);
  EXPECT_TRUE(record.ok()) << record.error().message();
  return record ? *std::move(record) : Record{};
}

std::size_t numbers(const std::string& line) {
  return 1 + static_cast<std::size_t>(std::ranges::count(line, ' '));
}

TEST(RecordFormat, AllFieldsInTheirOrder) {
  const PositionData data{.recordingTime = 4000000000U,
                          .pos = {.x = 1, .y = -2, .z = 3, .phi = 0.5F, .rho = 1.25F},
                          .var = {.x = 9}};
  EXPECT_EQ(recorded(tims::class_id::kPosition, data).line,
            "4000000000 1 -2 3 0.500000 0.000000 1.250000 9 0 0 0.000000 0.000000 0.000000\n");
}

TEST(RecordFormat, PlacesOnEarthAreExact) {
  const Record record = recorded(tims::class_id::kGps, GpsData{.latitude = 0.5, .utcTime = 1});
  EXPECT_TRUE(record.line.starts_with("0 0 0.5000000000000000 0.0000000000000000 0 0.000000 "));
  EXPECT_EQ(numbers(record.line), 22U);
}

TEST(RecordFormat, Sequences) {
  PilotData pilot;
  pilot.splines.resize(2);
  EXPECT_EQ(numbers(recorded(tims::class_id::kPilot, pilot).line), 1 + 6 + 6 + 3 + 1 + 2 * 31U);
  PathData path;
  path.splines.resize(2);
  EXPECT_EQ(numbers(recorded(tims::class_id::kPath, path).line), 1 + 1 + 2 * 28U);
  MclData mcl;
  mcl.points.resize(3);
  EXPECT_EQ(numbers(recorded(tims::class_id::kMcl, mcl).line), 1 + 6 + 1 + 3 * 4U);
}

TEST(RecordFormat, PointsHaveAFileOfTheirOwn) {
  Scan2dData scan{.recordingTime = 7};
  scan.points = {{.x = 1, .y = -2, .z = 3, .type = 16, .segment = 4, .intensity = 5}, {}};
  const Record record = recorded(tims::class_id::kScan2d, scan);
  EXPECT_EQ(record.line, "7 0 0 1 0 0 0 0 0.000000 0.000000 0.000000 2 3\n");
  EXPECT_EQ(record.suffix, ".2d");
  EXPECT_EQ(record.file, "1 -2 3 16 4 5\n0 0 0 0 0 0\n");
  EXPECT_EQ(record.raw_suffix, "");
  const Record binary = recorded(tims::class_id::kScan3d, Scan3dData{}, true);
  EXPECT_EQ(binary.suffix, ".3d");
  EXPECT_EQ(binary.raw_suffix, ".3d.raw");
  EXPECT_EQ(binary.raw.size(), 68U);
}

TEST(RecordFormat, CompressedPointsAreRecordedAsPoints) {
  Scan3dData scan{.pointNum = 100};
  scan.points.resize(100, {.x = 5, .y = -6, .intensity = 7});
  const std::string plain = recorded(tims::class_id::kScan3d, scan, true).file;
  ASSERT_TRUE(Scan3dCompression().compress(scan));
  const Record record = recorded(tims::class_id::kScan3d, scan, true);
  EXPECT_EQ(record.file, plain);
  EXPECT_EQ(record.raw.size(), 68U + 100 * 20);
  scan.compressedPoints[0] = std::byte{};
  EXPECT_EQ(recorded(tims::class_id::kScan3d, scan, true).file, "");
}

TEST(RecordFormat, Pictures) {
  CameraData picture{.width = 2, .height = 1, .depth = 8};
  picture.image = {std::byte('a'), std::byte('b')};
  EXPECT_EQ(recorded(tims::class_id::kCamera, picture).suffix, ".raw");
  EXPECT_EQ(recorded(tims::class_id::kCamera, picture).file, "ab");
  picture.mode = camera_mode::kJpeg;
  picture.colorFilterId = 2;
  EXPECT_EQ(recorded(tims::class_id::kCamera, picture).suffix, ".jpg");
}

TEST(RecordFormat, BytesAsNumbersOrAsTheyAre) {
  IoData io;
  io.values = {1, 255};
  EXPECT_EQ(recorded(tims::class_id::kIo, io).line, "0 2 1 255\n");
  EXPECT_EQ(recorded(tims::class_id::kIo, io, true).line, "0 2 3\n");
  EXPECT_EQ(recorded(tims::class_id::kIo, io, true).file.size(), 10U);
}

TEST(RecordFormat, Headings) {
  const RecordedClass* odometry = recorded_class(tims::class_id::kOdometry);
  EXPECT_EQ(heading(*odometry, *tims::Address::parse("Odometry(0/2)")),
            "% Odometry(0/2)\n% recordingTime pos.x pos.y pos.z pos.phi pos.psi pos.rho\n");
  const auto of = [](const char* module) {
    const tims::Address address = *tims::Address::parse(module);
    return heading(*recorded_class(address.fields().class_id), address);
  };
  EXPECT_EQ(of("Clock(1/0)"),
            "% Clock(1/0)\n% recordingTime hour second day month year utcTime dayOfWeek syncMode "
            "varT\n");
  EXPECT_EQ(of("Ladar(0/1)"),
            "% Ladar(0/1)\n% recordingTime duration maxRange startAngle endAngle pointNum "
            "point[0].angle point[0].distance point[0].type point[0].intensity\n");
  EXPECT_EQ(of("Scan2d(0/0)"),
            "% Scan2d(0/0)\n% recordingTime duration maxRange sectorNum sectorIndex refPos.x "
            "refPos.y refPos.z refPos.phi refPos.psi refPos.rho pointNum scan2dFileNum\n");
  EXPECT_EQ(
      of("Pilot(0/0)"),
      "% Pilot(0/0)\n% recordingTime pos.x pos.y pos.z pos.phi pos.psi pos.rho dest.x dest.y "
      "dest.z dest.phi dest.psi dest.rho speed curve distanceToDest splineNum "
      "spline[0].basepoint.x spline[0].basepoint.y spline[0].basepoint.speed "
      "spline[0].basepoint.maxRadius spline[0].basepoint.type spline[0].basepoint.request "
      "spline[0].basepoint.lbo spline[0].basepoint.id spline[0].basepoint.wayId "
      "spline[0].basepoint.layer spline[0].basepoint.actionStart spline[0].basepoint.actionEnd "
      "spline[0].startPos.x spline[0].startPos.y spline[0].startPos.rho spline[0].endPos.x "
      "spline[0].endPos.y spline[0].endPos.rho spline[0].centerPos.x spline[0].centerPos.y "
      "spline[0].centerPos.rho spline[0].length spline[0].radius spline[0].vMax spline[0].vStart "
      "spline[0].vEnd spline[0].accMax spline[0].decMax spline[0].type spline[0].request "
      "spline[0].lbo\n");
  EXPECT_TRUE(of("ServoDrive(0/3)").starts_with("% Servodrive(0/3)\n"));
  EXPECT_TRUE(of("GridMap(0/0)").starts_with("% Gridmap(0/0)\n"));
  EXPECT_EQ(recorded_class(tims::class_id::kJoystick), nullptr);
  std::int32_t all = 0;
  for (const RecordedClass& recorded : recorded_classes()) all += recorded.instances;
  EXPECT_EQ(all, 63);
}

TEST(RecordFormat, DataOfOtherClassesByTheirSchema) {
  const OdometryData data{.recordingTime = 7, .pos = {.x = 1, .rho = 0.5F}};
  std::vector<std::byte> body(encoded_size(data));
  ASSERT_TRUE(encode(data, body));
  const tims::Header header = tims::MessageView{}.header;
  const RecordedClass own{0x90, "Own", "own", 1, body.size(), "", nullptr, &kSchema<OdometryData>};
  const auto made = record(own, {header, body}, 1, false);
  const auto ours = recorded_class(tims::class_id::kOdometry)->record({header, body}, 1, false);
  ASSERT_TRUE(made && ours);
  EXPECT_EQ(made->line, ours->line);
  EXPECT_FALSE(record(own, {}, 1, false));
}

TEST(RecordFormat, RefusesWhatIsNoMessage) {
  const auto record = recorded_class(tims::class_id::kOdometry)->record({}, 1, false);
  EXPECT_FALSE(record.ok());
}

std::string refusal(std::string_view text) {
  const auto list = read_list(text);
  return list ? "it was read" : list.error().detail();
}

TEST(LogList, IsReadToAnEmptyLine) {
  const auto list = read_list("00120000 odo.dat\n0x00190100 scan.dat\r\n\nwhatever\n");
  ASSERT_TRUE(list.ok());
  ASSERT_EQ(list->size(), 2U);
  EXPECT_EQ((*list)[0].moduleMbx, tims::Address(0x00120000));
  EXPECT_EQ((*list)[0].filename, "odo.dat");
  EXPECT_EQ((*list)[0].logEnable, 0) << "until SET_LOG";
  EXPECT_EQ((*list)[0].maxDataLen, 28);
  EXPECT_EQ((*list)[1].moduleMbx, tims::Address(0x00190100));
  EXPECT_EQ((*list)[1].filename, "scan.dat");
  EXPECT_TRUE(read_list("")->empty());
  const auto named = read_list("ladar(0/1) l.dat\n");
  ASSERT_TRUE(named.ok()) << named.error().detail();
  EXPECT_EQ((*named)[0].moduleMbx, tims::Address(0x00140100));
}

TEST(LogList, ModulesByName) {
  const auto modules = modules_of("Odometry(0/0), Scan2d(3/2)");
  ASSERT_TRUE(modules.ok()) << modules.error().detail();
  ASSERT_EQ(modules->size(), 2U);
  EXPECT_EQ((*modules)[0].filename, "odometry_0.dat");
  EXPECT_EQ((*modules)[1].moduleMbx, tims::Address(0x03190200));
  EXPECT_EQ((*modules)[1].filename, "scan2d_3_2.dat");
  EXPECT_TRUE(modules_of(" ,, ")->empty());
  EXPECT_EQ(modules_of("Odometry").error().detail(),
            "Odometry: the address is neither a hexadecimal number nor a name such as Ladar(0/0)");
  std::string all;
  for (int i = 0; i < 100; ++i) all += "Ladar(0/" + std::to_string(i) + ") ";
  EXPECT_TRUE(modules_of(all).ok());
  EXPECT_EQ(modules_of(all + "Ladar(0/100)").error().detail(), "more than 100 modules");
}

TEST(LogList, AListOfAnotherLengthChangesAndExtendsIt) {
  DatalogData list;
  list.logInfo = {*log_info(tims::Address(0x00120000)), *log_info(tims::Address(0x00190000))};
  DatalogData wanted;
  wanted.logInfo = {{.logEnable = 1, .moduleMbx = tims::Address(0x00190000), .periodTime = 500}};
  ASSERT_TRUE(change_list(list, wanted).ok());
  EXPECT_EQ(list.logInfo.size(), 2U);
  EXPECT_EQ(list.logInfo[0].logEnable, 0);
  EXPECT_EQ(list.logInfo[1].logEnable, 1);
  EXPECT_EQ(list.logInfo[1].filename, "scan2d_0.dat");
  wanted.logInfo = {{.logEnable = 1, .moduleMbx = tims::Address(0x00140300)}};
  (void)wanted.logInfo[0].filename.assign("my.dat");
  ASSERT_TRUE(change_list(list, wanted).ok());
  ASSERT_EQ(list.logInfo.size(), 3U);
  EXPECT_EQ(list.logInfo[2].filename, "my.dat");
  EXPECT_EQ(list.logInfo[2].maxDataLen,
            static_cast<i32>(recorded_class(tims::class_id::kLadar)->body_max));
  wanted.logInfo = {{.logEnable = 1, .moduleMbx = tims::Address(0x00140400)},
                    {.logEnable = 1, .moduleMbx = tims::Address(0x00F70000)}};
  EXPECT_EQ(change_list(list, wanted).error().detail(),
            "data of class 247 (0xf7) are not recorded");
  EXPECT_EQ(list.logInfo.size(), 3U) << "unchanged";
  wanted.logInfo.clear();
  for (u32 i = 0; i < 100; ++i)
    wanted.logInfo.push_back({.moduleMbx = tims::Address(0x00160000 + (i << 8))});
  EXPECT_FALSE(change_list(list, wanted).ok());
  wanted.logInfo.resize(97);
  EXPECT_TRUE(change_list(list, wanted).ok());
  EXPECT_EQ(list.logInfo.size(), 100U);
}

TEST(LogList, RefusesWhatIsNone) {
  EXPECT_EQ(refusal("00120000\n"), "line 1: expected an address, a blank and a file name");
  EXPECT_EQ(refusal("00120000 a\nhello b\n"),
            "line 2: the address is neither a hexadecimal number nor a name such as Ladar(0/0)");
  EXPECT_EQ(refusal("Thermometr(0/0) b\n"), "line 1: no class is called Thermometr");
  EXPECT_EQ(refusal("Ladar(0/300) b\n"),
            "line 1: instance 300 is out of range: 0 to 255 with the address widths of this fleet");
  EXPECT_EQ(refusal("00170000 joystick.dat"), "line 1: data of class Joystick are not recorded");
  EXPECT_EQ(refusal("00F70000 own.dat"), "line 1: data of class 247 (0xf7) are not recorded");
  EXPECT_EQ(refusal("00120000 " + std::string(40, 'a')),
            "line 1: the file name is longer than 39 characters");
  std::string long_list;
  for (int i = 0; i < 101; ++i) long_list += "00120000 a\n";
  EXPECT_EQ(refusal(long_list), "line 101: more than 100 modules");
}

TEST(BaseOf, DotsOfFoldersDoNotCount) {
  EXPECT_EQ(base_of("/tmp/a.b/scan.dat"), "/tmp/a.b/scan");
  EXPECT_EQ(base_of("/tmp/a.b/scan"), "/tmp/a.b/scan");
  EXPECT_EQ(base_of("scan.1.dat"), "scan.1");
}

}  // namespace record_format_test

}  // namespace rack::datalog
