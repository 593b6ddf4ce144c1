#include "tests/bench/decoder_streams.h"

#include <cstdio>
#include <string>
#include <utility>

#include "components/devices/camera/ptz_camera.h"
#include "components/devices/chassis/mavlink_vehicle.h"
#include "components/devices/chassis/pioneer.h"
#include "components/devices/chassis/roomba_robot.h"
#include "components/devices/chassis/rover.h"
#include "components/devices/pins/io_board.h"
#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/cmps03_emulator.h"
#include "components/devices/positioning/dcf77_emulator.h"
#include "components/devices/positioning/nmea_emulator.h"
#include "components/devices/positioning/ublox.h"
#include "components/devices/positioning/ublox_emulator.h"
#include "components/devices/positioning/xsens_emulator.h"
#include "components/devices/scan3d/spinning_scanner.h"
#include "components/devices/scanners/hokuyo.h"
#include "components/devices/scanners/hokuyo_emulator.h"
#include "components/devices/scanners/ibeo.h"
#include "components/devices/scanners/ibeo_emulator.h"
#include "components/devices/scanners/ibeo_lux_emulator.h"
#include "components/devices/scanners/ld19_emulator.h"
#include "components/devices/scanners/lms200_emulator.h"
#include "components/devices/scanners/rplidar.h"
#include "components/devices/scanners/rplidar_emulator.h"
#include "components/devices/scanners/sick_cola.h"
#include "components/devices/scanners/sick_cola_emulator.h"
#include "components/devices/scanners/sick_compact_emulator.h"
#include "components/devices/scanners/sick_s_emulator.h"
#include "rack/devices/capture.h"
#include "rack/devices/virtual_line.h"

namespace tims::bench {
namespace {

namespace device = rack::device;
namespace emulator = rack::device::emulator;
using device::Arrival;
using device::Dialogue;
using device::Output;
using emulator::LineSettings;

constexpr std::size_t kStreamBytes = 1 << 18;
constexpr std::size_t kDatagramBytes = 1 << 22;  // some turns of 3D scanners
constexpr double kUsual = 200;                   // MB/s
constexpr double kModest = 100;

// --- how bytes arrive

constexpr LineSettings serial(std::uint32_t host_baud, std::uint32_t device_baud = 0) {
  constexpr std::size_t kPiece = 64;
  return {.has_rate = true,
          .host_baud = host_baud,
          .device_baud = device_baud == 0 ? host_baud : device_baud,
          .piece = kPiece};
}
constexpr LineSettings kTcp{.piece = 1448};         // segments
constexpr LineSettings kDatagrams{.is_bus = true};  // and CAN frames

// Records the bytes that a dialogue receives.
class Tap final : public Dialogue {
 public:
  Tap(Dialogue& inner, DeviceStream& stream) : inner_(inner), stream_(stream) {}

  void start(Time now, Output& out) override { inner_.start(now, out); }
  void on_arrival(const Arrival& arrival, Output& out) override {
    stream_.bytes.insert(stream_.bytes.end(), arrival.bytes.begin(), arrival.bytes.end());
    stream_.pieces.push_back({arrival.bytes.size(), arrival.id, arrival.first, arrival.last});
    inner_.on_arrival(arrival, out);
  }
  void on_timeout(Time now, Output& out) override { inner_.on_timeout(now, out); }
  [[nodiscard]] Time next_timeout() const override { return inner_.next_timeout(); }

 private:
  Dialogue& inner_;
  DeviceStream& stream_;
};

DeviceStream talk(Dialogue& host, Dialogue& emulated, const LineSettings& line) {
  DeviceStream stream;
  Tap tap(host, stream);
  emulator::VirtualLine between(tap, emulated, line);
  between.start();
  const std::size_t wanted = line.is_bus ? kDatagramBytes : kStreamBytes;
  between.run(std::chrono::hours(24), [&] { return stream.bytes.size() >= wanted; });
  return stream;
}

// --- decoders

struct Nobody final : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

// Takes all data as a driver does.
template <class Dialog, class Data>
struct Taker {
  std::size_t operator()(Dialog& dialogue) {
    std::size_t found = 0;
    while (dialogue.take(data, recorded)) ++found;
    return found;
  }
  Data data{};
  Time recorded{};
};

template <>
struct Taker<device::IbeoLux, rack::LadarData> {
  std::size_t operator()(device::IbeoLux& dialogue) {
    return (dialogue.take(scan, recorded) ? 1U : 0U) +
           (dialogue.take_objects(boxes, contours, recorded) ? 1U : 0U);
  }
  rack::LadarData scan{};
  rack::ObjRecogData boxes{};
  rack::ObjRecogData contours{};
  Time recorded{};
};

template <>
struct Taker<device::MavlinkVehicle, rack::ChassisData> {
  std::size_t operator()(device::MavlinkVehicle& dialogue) {
    return (dialogue.take(chassis, recorded) ? 1U : 0U) +
           (dialogue.take_gps(gps, recorded) ? 1U : 0U) +
           (dialogue.take_gyro(gyro, recorded) ? 1U : 0U) +
           (dialogue.take_position(position, recorded) ? 1U : 0U);
  }
  rack::ChassisData chassis{};
  rack::GpsData gps{};
  rack::GyroData gyro{};
  rack::PositionData position{};
  Time recorded{};
};

// Like a driver, but without sending.
template <class Dialog, class Data>
class DialogueDecoder final : public Decoder {
 public:
  explicit DialogueDecoder(std::unique_ptr<Dialog> dialogue) : dialogue_(std::move(dialogue)) {}

  std::size_t decode(const DeviceStream& stream, Duration later) override {
    if (!std::exchange(is_started_, true)) dialogue_->start(stream.pieces.front().first, nobody_);
    std::size_t found = 0;
    std::span<const std::byte> rest = stream.bytes;
    for (const Piece& piece : stream.pieces) {
      const Time now = piece.last + later;
      dialogue_->on_arrival({.bytes = rest.first(piece.size),
                             .first = piece.first + later,
                             .last = now,
                             .id = piece.id},
                            nobody_);
      rest = rest.subspan(piece.size);
      if (dialogue_->next_timeout() <= now) dialogue_->on_timeout(now, nobody_);
      found += take_(*dialogue_);
    }
    return found;
  }

 private:
  std::unique_ptr<Dialog> dialogue_;
  Nobody nobody_;
  Taker<Dialog, Data> take_;
  bool is_started_ = false;
};

// Recorded with a dialogue that sends, decoded by one that only receives.
template <class Dialog, class Data, class Settings>
Prepared prepared(Settings settings, Dialogue& emulated, const LineSettings& line) {
  Dialog host(settings);
  DeviceStream stream = talk(host, emulated, line);
  if constexpr (requires { settings.only_listen; }) settings.only_listen = true;
  return {std::move(stream),
          std::make_unique<DialogueDecoder<Dialog, Data>>(std::make_unique<Dialog>(settings))};
}

Prepared cola(device::ColaDialect dialect) {
  emulator::SickColaEmulator scanner({.dialect = dialect,
                                      .device = "LMS511",
                                      .scan_frequency = 2500,
                                      .start_angle = -50000,
                                      .step = 1667,
                                      .values = 1141});
  return prepared<device::SickCola, rack::LadarData>(device::SickColaSettings{.dialect = dialect},
                                                     scanner, kTcp);
}

Prepared hokuyo(emulator::HokuyoLanguage language) {
  emulator::Hokuyo scanner({.language = language});
  return prepared<device::Hokuyo, rack::LadarData>(device::HokuyoSettings{.cluster = 1}, scanner,
                                                   serial(115200, 19200));
}

Prepared rplidar(std::uint8_t type) {
  emulator::Rplidar scanner({.type = type});
  return prepared<device::Rplidar, rack::LadarData>(
      device::RplidarSettings{.only_points = type == device::rplidar::kPoints}, scanner,
      serial(115200));
}

template <class Emulator>
Prepared xsens() {
  Emulator gyro;
  return prepared<device::Xsens, rack::GyroData>(device::XsensSettings{}, gyro, serial(115200));
}

Prepared roomba(device::RoombaModel model, std::uint32_t baud) {
  device::RoombaEmulator robot(model);
  return prepared<device::Roomba, rack::ChassisData>(device::RoombaSettings{.model = model}, robot,
                                                     serial(baud));
}

Prepared dcf77(device::Dcf77Kind kind) {
  emulator::Dcf77Emulator clock({.kind = kind});
  return prepared<device::Dcf77, rack::ClockData>(kind, clock, serial(9600));
}

Prepared ouster() {
  emulator::OusterScanner scanner;
  const auto metadata = *device::OusterMetadata::parse(emulator::OusterScanner::metadata());
  device::Ouster host(metadata, {});
  return {talk(host, scanner, kDatagrams),
          std::make_unique<DialogueDecoder<device::Ouster, rack::Scan3dData>>(
              std::make_unique<device::Ouster>(metadata, device::SpinSettings{}))};
}

Prepared firmata() {
  emulator::IoBoard board;
  return prepared<device::Firmata, rack::IoData>(
      device::IoSettings{.layout = {.inputs = {2, 3}, .outputs = {13}, .analogs = {0, 1}}}, board,
      serial(57600));
}

// --- streams without an emulator

class RecordDecoder final : public Decoder {
 public:
  std::size_t decode(const DeviceStream& stream, Duration /*later*/) override {
    std::size_t found = 0;
    std::string_view text(reinterpret_cast<const char*>(stream.bytes.data()), stream.bytes.size());
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      const auto good = device::parse_record(text.substr(0, end), record_);
      found += good && *good ? 1U : 0U;
      text.remove_prefix(end + 1);
    }
    return found;
  }

 private:
  device::CaptureRecord record_;
};

Prepared lines(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {{.bytes = {bytes.begin(), bytes.end()}, .pieces = {{.size = bytes.size()}}},
          std::make_unique<RecordDecoder>()};
}

Prepared capture() {
  constexpr std::size_t kArrival = 64;
  const std::vector<std::byte> bytes(kArrival, std::byte{0x5A});
  std::string text;
  for (Duration time{}; text.size() < kStreamBytes; time += std::chrono::microseconds(1280))
    device::append_record(text, time, device::Direction::kReceived, 0, bytes);
  return lines(text);
}

Prepared candump() {
  std::string text;
  for (int i = 0; text.size() < kStreamBytes; ++i) {
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "(%d.%06d) can0 181#37010000%08X\n",
                  1700000000 + i / 1000, i % 1000 * 1000, static_cast<unsigned>(i));
    text += line.data();
  }
  return lines(text);
}

// --- the table

// An emulator without settings.
template <class Dialog, class Data, class Emulator, class Settings>
Prepared with(const Settings& settings, const LineSettings& line) {
  Emulator emulated;
  return prepared<Dialog, Data>(settings, emulated, line);
}

using namespace rack::device;
using rack::ChassisData;
using rack::LadarData;

constexpr DecoderCase kCases[] = {
    {"lms200", kModest,
     [] {
       return with<Lms200, LadarData, emulator::Lms200Emulator>(
           Lms200Settings{.baud = 500000, .mode = Lms200Mode::kFast}, serial(9600));
     }},
    {"cola-a", kModest, [] { return cola(ColaDialect::kAscii); }},
    {"cola-b", kModest, [] { return cola(ColaDialect::kBinary); }},
    {"sick-s", kUsual,
     [] {
       return with<SickS, LadarData, emulator::SickSEmulator>(SickSSettings{}, serial(500000));
     }},
    {"sick-compact", kUsual,
     [] {
       return with<SickCompact, LadarData, emulator::SickCompactEmulator>(SickCompactSettings{},
                                                                          kDatagrams);
     }},
    {"scip-1", kUsual, [] { return hokuyo(emulator::HokuyoLanguage::kScip1Only); }},
    {"scip-2", kUsual, [] { return hokuyo(emulator::HokuyoLanguage::kScip2); }},
    {"rplidar-81", kUsual, [] { return rplidar(rplidar::kPoints); }},
    {"rplidar-82", kUsual, [] { return rplidar(rplidar::kPairs); }},
    {"rplidar-84", kUsual, [] { return rplidar(rplidar::kTriples); }},
    {"rplidar-85", kUsual, [] { return rplidar(rplidar::kDense); }},
    {"ld19", kUsual,
     [] { return with<Ld19, LadarData, emulator::Ld19>(Ld19Settings{}, serial(230400)); }},
    {"ibeo", kUsual,
     [] { return with<Ibeo, LadarData, emulator::Ibeo>(IbeoSettings{}, kDatagrams); }},
    {"ibeo-lux", kUsual,
     [] { return with<IbeoLux, LadarData, emulator::IbeoLux>(IbeoLuxSettings{}, kTcp); }},
    {"velodyne", kUsual,
     [] {
       return with<Velodyne, rack::Scan3dData, emulator::VelodyneScanner>(SpinSettings{},
                                                                          kDatagrams);
     }},
    {"ouster", kUsual, ouster},
    {"nmea", kModest,
     [] {
       return with<NmeaReceiver, rack::GpsData, emulator::NmeaEmulator>(NmeaSettings{},
                                                                        serial(4800));
     }},
    {"ubx", kUsual,
     [] {
       return with<Ublox, rack::GpsData, emulator::UbloxEmulator>(UbloxSettings{}, serial(38400));
     }},
    {"xsens-mtdata2", kUsual, xsens<emulator::XsensEmulator>},
    {"xsens-mtdata", kUsual, xsens<emulator::XsensOldEmulator>},
    {"cmps03", kUsual,
     [] {
       return with<Cmps03, rack::CompassData, emulator::Cmps03Emulator>(Cmps03Settings{},
                                                                        serial(57600));
     }},
    {"dcf77-mbg", kUsual, [] { return dcf77(Dcf77Kind::kMeinberg); }},
    {"dcf77-emc", kUsual, [] { return dcf77(Dcf77Kind::kEmcPro); }},
    {"p2os", kUsual,
     [] { return with<P2os, ChassisData, PioneerEmulator>(P2osSettings{}, serial(9600)); }},
    {"roomba", kUsual, [] { return roomba(RoombaModel::kRoomba, 57600); }},
    {"create2", kUsual, [] { return roomba(RoombaModel::kCreate2, 115200); }},
    {"mavlink", kUsual,
     [] {
       return with<MavlinkVehicle, ChassisData, RoverEmulator>(MavlinkSettings{}, serial(57600));
     }},
    {"visca", kUsual,
     [] {
       return with<Visca, rack::PtzDriveData, emulator::PtzCamera>(ViscaSettings{}, serial(9600));
     }},
    {"firmata", kUsual, firmata},
    {"capture", kUsual, capture},
    {"candump", kUsual, candump},
};

}  // namespace

std::span<const DecoderCase> decoder_cases() { return kCases; }

}  // namespace tims::bench
