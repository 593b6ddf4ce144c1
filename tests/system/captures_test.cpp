// Recordings of real devices, played to the real programs: the numbers of data sets and of invalid
// telegrams are those in the recordings' READMEs. They are played by play:, and by `timsctl device
// play` at ports and terminals.
//
// Recordings that must not be copied into this repository (CAN of cars), and complete versions of
// shortened ones, are in the folder $RACK_TEST_DATA; without it those tests are skipped.
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>
#include <thread>

#include <boost/json.hpp>
#include <gmock/gmock.h>
#include <sys/socket.h>

#include "components/devices/io/line.h"
#include "components/devices/scanners/cola_scan.h"
#include "components/devices/scanners/hokuyo_emulator.h"
#include "os/clock.h"
#include "rack/devices/capture.h"
#include "rack/devices/device.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/scan3d.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace captures_test {

namespace device = rack::device;
namespace json = boost::json;
using testing::HasSubstr;

constexpr std::uint32_t kData = 0x00020002;
const std::string kRecordings = TIMS_TEST_DATA_DIR "/devices/";

// Counts the data sets of a component since its start.
class Counter : public rack::Proxy {
 public:
  using Proxy::Proxy;
  std::int64_t data_sets() {
    const auto reply = query<rack::ListenersData>(type::kGetListeners, type::kListeners);
    EXPECT_TRUE(reply) << reply.error().message();
    return reply ? reply->dataSets : -1;
  }
};

std::vector<std::string> tokens_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

class CapturesTest : public ModulesTest {
 protected:
  template <typename P>
  P at(const std::string& address) {
    return proxy<P>(Address::parse(address)->raw());
  }
  std::int64_t data_sets(const std::string& address) { return at<Counter>(address).data_sets(); }

  // The path of the unpacked file.
  std::string unpacked(const std::string& path) {
    const std::string to = folder_.path() / std::filesystem::path(path).filename().stem();
    const std::string with = path.ends_with(".xz") ? "xz" : path.ends_with(".gz") ? "gzip" : "";
    if (with.empty()) return path;
    auto child = ChildProcess::start({"sh", "-c", with + " -dc '" + path + "' >'" + to + "'"});
    EXPECT_TRUE(child) << child.error().message();
    const auto status = child->wait();
    EXPECT_TRUE(status && status->success()) << path << child->output();
    return to;
  }

  ChildProcess& start_with(const std::string& program, const std::string& arguments,
                           const std::string& address) {
    auto all = tokens_of(arguments);
    for (std::string& argument : all)
      if (const auto data = argument.find("DATA/"); data != std::string::npos)
        argument.replace(data, 5, kRecordings);
    all.push_back("--device=" + address);
    return start(program, all);
  }

  // timsctl device play, in place of the device.
  ChildProcess play(const std::string& file, const std::string& address) {
    auto player = ChildProcess::start(
        {std::string(TIMS_PROGRAMS) + "/timsctl", "device", "play", file, address}, at_router());
    EXPECT_TRUE(player) << player.error().message();
    const auto ready = player->wait_for_line("playing ");
    EXPECT_TRUE(ready) << ready.error().message();
    return std::move(*player);
  }

  TemporaryFolder folder_;
};

// --- by play:

constexpr double kDegree = std::numbers::pi / 180;

struct Capture {
  std::string file;
  std::string program;
  std::string arguments;
  std::string address;
  std::int64_t data;        // number of data sets
  std::int64_t broken = 0;  // invalid telegrams
  // In degrees and mm, if the README states them.
  std::array<double, 4> latitude_longitude{};
  std::array<int, 2> distance{};
};
void PrintTo(const Capture& capture, std::ostream* out) { *out << capture.file; }

// The sentence that completes a fix. Without RMC another sentence is used from the fourth fix on.
constexpr const char* kGga = "--trigMsgStart=1 --trigMsgEnd=1";
constexpr const char* kRmc = "";

Capture gps(std::string file, std::int64_t data, std::int64_t broken = 0,
            const std::string& arguments = kGga, std::array<double, 4> box = {}) {
  return {std::move(file), "GpsNmea", arguments + " --positionInst=-1", "Gps(0/0)", data,
          broken,          box};
}
Capture ublox(const std::string& name, std::int64_t data, std::int64_t broken = 0) {
  return {"ubx/" + name, "GpsUblox", "--positionInst=-1", "Gps(0/0)", data, broken};
}
Capture sick(std::string file, std::int64_t scans, std::array<int, 2> distance) {
  return {std::move(file), "LadarSickCola", "", "Ladar(0/0)", scans, 0, {}, distance};
}

class PlayedTest : public CapturesTest, public testing::WithParamInterface<Capture> {
 protected:
  static std::string path() {
    if (GetParam().file.front() != '$') return kRecordings + GetParam().file;
    const char* const folder = std::getenv("RACK_TEST_DATA");
    return folder == nullptr ? "" : folder + GetParam().file.substr(1);
  }

  void expect_values() {
    if (GetParam().latitude_longitude[0] != 0) {
      const auto fix = at<rack::GpsProxy>(GetParam().address).get_data();
      ASSERT_TRUE(fix) << fix.error().message();
      const auto& [south, north, west, east] = GetParam().latitude_longitude;
      EXPECT_TRUE(fix->latitude >= south * kDegree && fix->latitude <= north * kDegree &&
                  fix->longitude >= west * kDegree && fix->longitude <= east * kDegree)
          << fix->latitude / kDegree << ' ' << fix->longitude / kDegree;
    }
    if (GetParam().distance[1] != 0) {
      const auto scan = at<rack::LadarProxy>(GetParam().address).get_data();
      ASSERT_TRUE(scan) << scan.error().message();
      for (const rack::LadarPoint& point : scan->points) {
        if (point.type == rack::ladar_point::kInvalid) continue;
        ASSERT_GE(point.distance, GetParam().distance[0]);
        ASSERT_LE(point.distance, GetParam().distance[1]);
      }
    }
  }
};

TEST_P(PlayedTest, YieldsTheDataOfTheRecording) {
  const Capture& capture = GetParam();
  if (path().empty()) GTEST_SKIP() << "RACK_TEST_DATA is not set: no complete recordings";
  if (capture.program == std::string("CameraV4l") && RACK_WITH_OPENCV == 0)
    GTEST_SKIP() << "built without pictures";
  // Raw bytes have no times; they are played in pieces of this baud rate.
  auto& program = start_with(capture.program, capture.arguments,
                             "play:" + unpacked(path()) + "?speed=max&baud=115200");
  // A driver without data does not answer.
  constexpr Duration kNotLong = 1ms;
  rack::Proxy component(*work_, *Address::parse(capture.address),
                        {.on = capture.data == 0 ? kNotLong : kPatience});
  const auto on = component.on();
  ASSERT_EQ(on.ok(), capture.data > 0) << on.error().message();
  const auto over = program.wait_for_line("end of the recording");
  ASSERT_TRUE(over) << over.error().message();
  EXPECT_THAT(*over, HasSubstr(": end of the recording, " + std::to_string(capture.broken) +
                               " invalid telegrams"));
  EXPECT_EQ(data_sets(capture.address), capture.data);
  expect_values();
}

std::string name_of(const testing::TestParamInfo<Capture>& capture) {
  std::string name = capture.param.file;
  std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
  return name;
}

INSTANTIATE_TEST_SUITE_P(
    Nmea, PlayedTest,
    testing::Values(gps("nmea/plaka-boat-cut.nmea", 297, 0, kRmc,
                        {59.8555, 60.0855, 23.3265, 23.5395}),
                    gps("nmea/gofree-corrupted.nmea", 142, 142),
                    gps("nmea/gps-20min-cut.nmea", 1005, 0, kGga, {52.36, 52.38, 4.90, 4.92}),
                    gps("nmea/bt451.log", 17), gps("nmea/ublox-lea-4h.log", 14),
                    gps("nmea/quectel-eg25-g.log", 60), gps("nmea/haicom-305N.log", 73),
                    gps("nmea/garmin-10x.log", 14), gps("nmea/nmea-rtk.log", 122),
                    gps("nmea/telit-he910.log", 224), gps("nmea/hemi.log", 215),
                    gps("nmea/unicore-um621.log", 20), gps("nmea/ublox-zed-f9p-nmea.log", 29),
                    gps("nmea/ublox-neo-m9n-nmea.log", 61),
                    gps("nmea/gp-320fw-2019-04-07-coldboot.log", 16, 41, kRmc),
                    gps("nmea/firefly-II.log", 23, 23, kRmc), gps("nmea/garmin48.log", 7, 1)),
    name_of);
INSTANTIATE_TEST_SUITE_P(
    Ubx, PlayedTest,
    testing::Values(ublox("2023-4-17_82912_serial-COM3.ubx", 90),
                    ublox("pygpsdata-BADCK2.log", 1, 2), ublox("pygpsdata-BADEOF1.log", 1),
                    ublox("pygpsdata-BADEOF2.log", 1), ublox("pygpsdata-BADHDR.log", 0),
                    ublox("pygpsdata-CFG.log", 0), ublox("pygpsdata-ESF.log", 0),
                    ublox("pygpsdata-HNR.log", 0), ublox("pygpsdata-MIXED-RTCM3.log", 1),
                    ublox("pygpsdata-MIXED-RTCM3BADCRC.log", 1), ublox("pygpsdata-MIXED.log", 39),
                    ublox("pygpsdata-NAV.log", 1), ublox("ucenter-ZEDF9P-configdebug.log", 2)),
    name_of);
INSTANTIATE_TEST_SUITE_P(Sick, PlayedTest,
                         testing::Values(sick("sick/lms111.cola-b.txt", 97, {62, 1841}),
                                         sick("sick/lms511-a.cola-b.txt", 32, {282, 2921}),
                                         sick("sick/lms511.cola-b.txt", 32, {420, 2919}),
                                         sick("sick/tim781s.cola-b.txt", 33, {277, 2983}),
                                         sick("sick/tim55x.cola-a.txt", 1, {})),
                         name_of);
INSTANTIATE_TEST_SUITE_P(
    Others, PlayedTest,
    testing::Values(Capture{"ouster/OS-0-32-U1_v2.2.0_1024x10.pcap.gz", "Scan3dOuster",
                            "--metadata=DATA/ouster/OS-0-32-U1_v2.2.0_1024x10.json", "Scan3d(0/0)",
                            1, 10},
                    Capture{"ouster/OS-0-32-U1_v2.2.0_1024x10-single-packet.pcap", "Scan3dOuster",
                            "--metadata=DATA/ouster/OS-0-32-U1_v2.2.0_1024x10.json", "Scan3d(0/0)",
                            0},
                    Capture{"vlp16.pcap", "Scan3dVelodyne", "--sectors=64", "Scan3d(0/0)", 0},
                    Capture{"camera/donkeycar-20.cap", "CameraV4l",
                            "--mode=jpeg --width=160 --height=120", "Camera(0/0)", 20}),
    name_of);
// Complete recordings; numbers from the READMEs in that folder. gps-20min ends within a sentence.
INSTANTIATE_TEST_SUITE_P(Whole, PlayedTest,
                         testing::Values(sick("$/sick/lms111.cola-b.txt.xz", 175, {62, 1841}),
                                         sick("$/sick/lms511-a.cola-b.txt.xz", 136, {282, 2921}),
                                         sick("$/sick/lms511.cola-b.txt.xz", 174, {420, 2919}),
                                         sick("$/sick/tim781s.cola-b.txt.xz", 140, {277, 2983}),
                                         gps("$/nmea/plaka-boat.nmea.xz", 7247, 0, kRmc,
                                             {59.8555, 60.0855, 23.3265, 23.5395}),
                                         gps("$/nmea/gps-20min.nmea.xz", 1201, 0, kGga,
                                             {52.36, 52.38, 4.90, 4.92})),
                         name_of);

// --- the data sets equal the recorded ones

// All scans of a recording, decoded here.
std::vector<rack::LadarData> scans_of(const std::string& file) {
  std::vector<rack::LadarData> scans;
  std::ifstream lines(kRecordings + file);
  device::ColaTelegrams telegrams;
  device::ColaScan scan;
  device::CaptureRecord record;
  for (std::string line; std::getline(lines, line);) {
    if (const auto parsed = device::parse_record(line, record); !parsed || !*parsed) continue;
    telegrams.add({.bytes = record.bytes});
    for (device::ColaTelegram telegram; telegrams.next(telegram);) {
      if (!device::decode_cola_scan(telegram, scan)) continue;
      EXPECT_TRUE(device::scan_of_cola(scan, {}, scans.emplace_back()));
    }
  }
  return scans;
}

std::vector<int> distances_of(const rack::LadarData& scan) {
  std::vector<int> distances;
  for (const rack::LadarPoint& point : scan.points) distances.push_back(point.distance);
  return distances;
}

TEST_F(CapturesTest, ScansOfSickArriveInOrder) {
  const auto expected = scans_of("sick/lms111.cola-b.txt");
  ASSERT_EQ(expected.size(), 97U);
  start_with("LadarSickCola", "", "play:" + kRecordings + "sick/lms111.cola-b.txt");
  Mailbox data = open(*session_, kData, {.slots = 200, .body_max = 40000});
  auto ladar = at<rack::LadarProxy>("Ladar(0/0)");
  ASSERT_TRUE(ladar.on());
  ASSERT_TRUE(ladar.get_cont_data(0, data.address()));
  rack::LadarData scan;
  for (std::size_t next = 0; next < expected.size(); ++next) {
    const auto message = data.peek_for(kPatience);
    ASSERT_TRUE(message) << next;
    ASSERT_TRUE(ladar.decode_stream(*message, scan));
    EXPECT_EQ(scan.points.size(), 541U);
    const std::vector<int> distances = distances_of(scan);
    // The first scans may have been sent before the stream was requested.
    while (next < expected.size() && distances_of(expected[next]) != distances) ++next;
    ASSERT_LT(next, expected.size()) << "a scan that is not in the recording";
  }
}

TEST_F(CapturesTest, TheTelegramOfAnLms200) {
  std::ifstream hex(kRecordings + "sick/lms200-one-telegram.hex");
  std::string telegram;
  for (std::string token; hex >> token;) telegram += token;
  const std::string file = folder_.path() / "lms200.cap";
  std::ofstream(file) << "0.000000 " << telegram << '\n';
  start_with("LadarSickLms200", "", "play:" + file);
  auto ladar = at<rack::LadarProxy>("Ladar(0/0)");
  ASSERT_TRUE(ladar.on());
  const auto scan = ladar.get_data();
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->points.size(), 361U);
  EXPECT_EQ(data_sets("Ladar(0/0)"), 1);
}

TEST_F(CapturesTest, ATurnOfAnOuster) {
  const std::string name = kRecordings + "ouster/OS-0-32-U1_v2.2.0_1024x10";
  start_with("Scan3dOuster", "--metadata=" + name + ".json",
             "play:" + unpacked(name + ".pcap.gz") + "?speed=max");
  auto scanner = at<rack::Scan3dProxy>("Scan3d(0/0)");
  ASSERT_TRUE(scanner.on());
  const auto scan = scanner.get_data();
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->pointNum, 32768);
  EXPECT_EQ(std::ranges::count(scan->points, 0, &rack::ScanPoint::type), 21631);
}

TEST_F(CapturesTest, PicturesOfACamera) {
  if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "built without pictures";
  const std::string file = kRecordings + "camera/donkeycar-20.cap";
  auto& program = start_with("CameraV4l", "--mode=jpeg --width=160 --height=120",
                             "play:" + file + "?speed=max");
  auto camera = at<rack::CameraProxy>("Camera(0/0)");
  ASSERT_TRUE(camera.on());
  ASSERT_TRUE(program.wait_for_line("end of the recording"));
  const auto picture = camera.get_data();
  ASSERT_TRUE(picture) << picture.error().message();
  // The last picture equals the recorded bytes.
  std::ifstream lines(file);
  device::CaptureRecord record;
  for (std::string line; std::getline(lines, line);)
    ASSERT_TRUE(device::parse_record(line, record)) << line;
  EXPECT_TRUE(std::ranges::equal(picture->image, record.bytes));
  EXPECT_EQ(picture->width, 160);
  EXPECT_EQ(picture->height, 120);
}

// --- played by programs in place of the device

// Each connection gets the recording from its start. If several fixes arrive together, only the
// newest is published.
TEST_F(CapturesTest, AReceiverAtAPort) {
  const std::string address = "tcp:127.0.0.1:" + free_port(SOCK_STREAM);
  auto player = play(kRecordings + "nmea/gofree-corrupted.nmea?speed=max&baud=115200", address);
  auto& program = start_with("GpsNmea", std::string(kGga) + " --positionInst=-1", address);
  ASSERT_TRUE(at<rack::GpsProxy>("Gps(0/0)").on());
  const auto over = program.wait_for_line("invalid telegrams");
  ASSERT_TRUE(over) << over.error().message();
  EXPECT_THAT(*over, HasSubstr(": 142 invalid telegrams"));
  EXPECT_GT(data_sets("Gps(0/0)"), 1);
  const auto status = player.wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_THAT(player.output(), HasSubstr(" played\n"));
}

TEST_F(CapturesTest, AReceiverAtATerminal) {
  const std::string path = folder_.path() / "gps";
  const auto player = play(kRecordings + "nmea/nmea-rtk.log?speed=max&loop=1&baud=115200",
                           "pty:" + path + "?baud=115200");
  auto& program = start_with("GpsNmea", std::string(kGga) + " --positionInst=-1 --baudrate=115200",
                             "serial:" + path);
  auto gps = at<rack::GpsProxy>("Gps(0/0)");
  ASSERT_TRUE(gps.on());
  for (int i = 0; i < 5; ++i) {
    const auto fix = gps.get_next_data(kPatience);
    ASSERT_TRUE(fix) << fix.error().message();
    EXPECT_NE(fix->mode & rack::gps_mode::kDifferential, 0);
  }
  // The driver may have started reading within a sentence.
  ASSERT_TRUE(gps.off());
  EXPECT_THAT(program.output(), testing::AnyOf(testing::Not(HasSubstr("invalid telegrams")),
                                               HasSubstr(", 1 invalid telegrams")));
}

TEST_F(CapturesTest, AScannerThatSendsDatagrams) {
  const std::string port = free_port(SOCK_DGRAM);
  const std::string name = kRecordings + "ouster/OS-0-32-U1_v2.2.0_1024x10";
  const auto player =
      play(unpacked(name + ".pcap.gz") + "?loop=1", "udp:127.0.0.1:" + port + "?local=0");
  start_with("Scan3dOuster", "--metadata=" + name + ".json", "udp::" + port);
  auto scanner = at<rack::Scan3dProxy>("Scan3d(0/0)");
  ASSERT_TRUE(scanner.on());
  EXPECT_TRUE(eventually(
      [&] {
        const auto scan = scanner.get_next_data(kPatience);
        return scan && std::ranges::count(scan->points, 0, &rack::ScanPoint::type) == 21631;
      },
      "a complete turn"));
}

// An emulated URG-04LX that sends recorded measurements.
class MeasuredHokuyo {
 public:
  MeasuredHokuyo(std::vector<std::vector<std::uint16_t>> scans, const std::string& address)
      : scanner_({.parameters = fast(), .scans = std::move(scans)}) {
    auto line = device::open_line(*device::DeviceAddress::parse(address), 0);
    EXPECT_TRUE(line) << line.error().message();
    device_ = device::Device::with(std::move(*line), scanner_);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) (void)device_->wait(os::now() + 20ms);
    });
  }
  ~MeasuredHokuyo() { thread_ = {}; }

 private:
  // Faster than 100 ms per turn, to shorten the test.
  static device::ScipParameters fast() {
    device::ScipParameters parameters{.model = "URG-04LX(Hokuyo Automatic Co.,Ltd.)"};
    parameters.turns_of_minute = 6000;
    return parameters;
  }

  device::emulator::Hokuyo scanner_;
  std::unique_ptr<device::Device> device_;
  std::jthread thread_;
};

TEST_F(CapturesTest, ScansOfAHokuyoAtAPort) {
  std::ifstream file(kRecordings + "hokuyo/exp1-80-scans.dat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto originals = device::emulator::scans_of_log(text, 80);
  ASSERT_EQ(originals.size(), 80U);
  std::set<std::vector<int>> missing;
  for (const auto& original : originals) {
    std::vector<int> distances;  // clockwise; error codes are not distances
    for (std::size_t step = 682; step-- > 0;)
      distances.push_back(original[step] < 20 ? 0 : original[step]);
    missing.insert(distances);
  }
  const std::string address = "tcp:127.0.0.1:" + free_port(SOCK_STREAM);
  const MeasuredHokuyo scanner(originals, address);
  start_with("LadarHokuyoUrg", "--cluster=1", address);
  Mailbox data = open(*session_, kData, {.slots = 100, .body_max = 40000});
  auto ladar = at<rack::LadarProxy>("Ladar(0/0)");
  ASSERT_TRUE(ladar.on());
  ASSERT_TRUE(ladar.get_cont_data(0, data.address()));
  std::size_t points = 0;
  std::size_t codes = 0;
  rack::LadarData scan;
  while (!missing.empty()) {
    const auto message = data.peek_for(kPatience);
    ASSERT_TRUE(message) << missing.size() << " scans are missing";
    ASSERT_TRUE(ladar.decode_stream(*message, scan));
    const std::vector<int> distances = distances_of(scan);
    if (missing.erase(distances) == 0) continue;
    points += distances.size();
    codes += static_cast<std::size_t>(std::ranges::count(distances, 0));
  }
  EXPECT_EQ(points, 54'560U);
  EXPECT_EQ(codes, 32'811U);
}

// --- CAN recordings of cars; there is no driver for them

struct Bus {
  const char* name;
  std::uint64_t frames;
  std::size_t ids;
  double seconds;
};
void PrintTo(const Bus& bus, std::ostream* out) { *out << bus.name; }
class BusTest : public CapturesTest, public testing::WithParamInterface<Bus> {};

TEST_P(BusTest, HasItsFramesAndIdentifiers) {
  const char* const folder = std::getenv("RACK_TEST_DATA");
  if (folder == nullptr) GTEST_SKIP() << "RACK_TEST_DATA is not set: no recordings of cars";
  const auto path = unpacked(std::string(folder) + "/can/" + GetParam().name + ".candump.xz");
  auto child = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/timsctl", "device", "play", path, "-j"}, at_router());
  ASSERT_TRUE(child) << child.error().message();
  const auto status = child->wait();
  ASSERT_TRUE(status && status->success()) << child->output();
  const json::value report = json::parse(child->standard_output());
  EXPECT_EQ(report.at("received").at("records").to_number<std::uint64_t>(), GetParam().frames);
  EXPECT_EQ(report.at("ids").as_array().size(), GetParam().ids);
  EXPECT_NEAR(report.at("duration_s").to_number<double>(), GetParam().seconds, 0.0051);
  EXPECT_EQ(report.at("backwards").to_number<std::uint64_t>(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Cars, BusTest,
                         testing::Values(Bus{"yaris2009-accellog", 1268, 28, 7.24},
                                         Bus{"yaris2009-aconoff", 3841, 28, 22.06},
                                         Bus{"yaris2009-steering", 1769, 28, 10.13},
                                         Bus{"yaris2009-turnonstockecu", 2233, 28, 14.13},
                                         Bus{"scion-xb-speed", 8762, 48, 9.23},
                                         Bus{"ralliart-small-drive", 40163, 41, 22.57},
                                         Bus{"camaro-turn-wheel", 9689, 66, 5.88}),
                         [](const testing::TestParamInfo<Bus>& bus) {
                           std::string name = bus.param.name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace captures_test
}  // namespace tims::test
