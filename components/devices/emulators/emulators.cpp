#include "components/devices/emulators/emulators.h"

#include <algorithm>

#include "components/devices/camera/ip_camera.h"
#include "components/devices/camera/ptz_camera.h"
#include "components/devices/chassis/er1_robot.h"
#include "components/devices/chassis/motor_bus.h"
#include "components/devices/chassis/pioneer.h"
#include "components/devices/chassis/roomba_robot.h"
#include "components/devices/chassis/rover.h"
#include "components/devices/pins/io_board.h"
#include "components/devices/positioning/cmps03_emulator.h"
#include "components/devices/positioning/dcf77_emulator.h"
#include "components/devices/positioning/nmea_emulator.h"
#include "components/devices/positioning/ublox_emulator.h"
#include "components/devices/positioning/xsens_emulator.h"
#include "components/devices/scan3d/spinning_scanner.h"
#include "components/devices/scanners/hokuyo_emulator.h"
#include "components/devices/scanners/ibeo_emulator.h"
#include "components/devices/scanners/ibeo_lux_emulator.h"
#include "components/devices/scanners/ld19_emulator.h"
#include "components/devices/scanners/lms200_emulator.h"
#include "components/devices/scanners/rplidar_emulator.h"
#include "components/devices/scanners/sick_cola_emulator.h"
#include "components/devices/scanners/sick_compact_emulator.h"
#include "components/devices/scanners/sick_s_emulator.h"

namespace rack::device {
namespace {

// A device that returns received bytes, to test a line and `timsctl device record`.
class Echo final : public Dialogue {
 public:
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output& out) override {
    out.send(arrival.bytes, arrival.id);
  }
};

template <class Emulator>
std::unique_ptr<Dialogue> make(const Scene&) {
  return std::make_unique<Emulator>();
}
template <std::unique_ptr<Dialogue> (*make)()>
std::unique_ptr<Dialogue> bus(const Scene&) {
  return make();
}

// Creates an emulator from its settings and the scene.
template <class Emulator, class Settings>
std::unique_ptr<Dialogue> seeing(const Scene& scene, Settings settings) {
  if (scene.sight) settings.sight = scene.sight;
  return std::make_unique<Emulator>(settings);
}
template <class Emulator, class Settings>
std::unique_ptr<Dialogue> seeing(const Scene& scene) {
  return seeing<Emulator>(scene, Settings{});
}
template <class Scanner>
std::unique_ptr<Dialogue> spinning(const Scene& scene) {
  return scene.sight ? std::make_unique<Scanner>(scene.sight) : std::make_unique<Scanner>();
}
template <class Emulator, class Settings>
std::unique_ptr<Dialogue> driven(const Scene& scene, Settings settings) {
  if (scene.course) settings.course = scene.course;
  return std::make_unique<Emulator>(settings);
}

std::unique_ptr<Dialogue> make_cola_ascii(const Scene& scene) {
  return seeing<emulator::SickColaEmulator>(
      scene, emulator::SickColaEmulatorSettings{.dialect = ColaDialect::kAscii});
}
std::unique_ptr<Dialogue> make_s3000(const Scene& scene) {
  return seeing<emulator::SickSEmulator>(
      scene, emulator::SickSEmulatorSettings{.device = SickSDevice::kS3000});
}

std::unique_ptr<Dialogue> make_nmea(const Scene& scene) {
  emulator::NmeaEmulatorSettings settings;
  if (scene.period.count() > 0) settings.period = scene.period;
  return driven<emulator::NmeaEmulator>(scene, settings);
}
std::unique_ptr<Dialogue> make_ublox(const Scene& scene) {
  return driven<emulator::UbloxEmulator>(scene, emulator::UbloxEmulatorSettings{});
}
std::unique_ptr<Dialogue> make_ublox_m8(const Scene& scene) {
  return driven<emulator::UbloxEmulator>(
      scene, emulator::UbloxEmulatorSettings{.generation = 8, .baud = 9600});
}

std::unique_ptr<Dialogue> make_xsens_of(const Scene& scene, bool is_old) {
  emulator::XsensEmulatorSettings settings{.is_old = is_old};
  if (scene.inertia) settings.inertia = scene.inertia;
  return std::make_unique<emulator::XsensEmulator>(settings);
}
std::unique_ptr<Dialogue> make_xsens(const Scene& scene) { return make_xsens_of(scene, false); }
std::unique_ptr<Dialogue> make_xsens_mtx(const Scene& scene) { return make_xsens_of(scene, true); }

std::unique_ptr<Dialogue> make_cmps03(const Scene& scene) {
  return scene.heading ? std::make_unique<emulator::Cmps03Emulator>(scene.heading)
                       : std::make_unique<emulator::Cmps03Emulator>();
}

std::unique_ptr<Dialogue> make_roomba(const Scene&) {
  return std::make_unique<RoombaEmulator>(RoombaModel::kRoomba);
}
std::unique_ptr<Dialogue> make_create2(const Scene&) {
  return std::make_unique<RoombaEmulator>(RoombaModel::kCreate2);
}
std::unique_ptr<Dialogue> make_ip_camera(const Scene& scene) {
  return std::make_unique<emulator::IpCamera>(
      emulator::IpCameraSettings{.pictures = scene.pictures});
}
std::unique_ptr<Dialogue> make_ptz_camera_over_ip(const Scene&) {
  return std::make_unique<emulator::PtzCamera>(true);
}

constexpr EmulatorInfo kEmulators[] = {
    EmulatorInfo{"hokuyo", "Hokuyo URG-04LX", "LadarHokuyoUrg", "pty:/tmp/hokuyo", 19200,
                 Senses::kSight, seeing<emulator::Hokuyo, emulator::HokuyoSettings>},
    EmulatorInfo{"ibeo", "Ibeo LD-A", "LadarIbeo", "can:vcan0", 0, Senses::kSight,
                 seeing<emulator::Ibeo, emulator::IbeoSettings>},
    EmulatorInfo{"ibeo-lux", "Ibeo Lux", "LadarIbeoLux", "tcp:127.0.0.1:12002", 0, Senses::kSight,
                 seeing<emulator::IbeoLux, emulator::IbeoLuxSettings>},
    EmulatorInfo{"ld19", "LDROBOT LD19", "LadarRplidar", "pty:/tmp/ld19", 230400, Senses::kSight,
                 seeing<emulator::Ld19, emulator::Ld19Settings>},
    EmulatorInfo{"rplidar", "Slamtec RPLIDAR A1", "LadarRplidar", "pty:/tmp/rplidar", 115200,
                 Senses::kSight, seeing<emulator::Rplidar, emulator::RplidarSettings>},
    EmulatorInfo{"lms200", "SICK LMS200", "LadarSickLms200", "pty:/tmp/lms200", 9600,
                 Senses::kSight,
                 seeing<emulator::Lms200Emulator, emulator::Lms200EmulatorSettings>},
    EmulatorInfo{"sick-cola", "SICK LMS111, CoLa B", "LadarSickCola", "tcp:127.0.0.1:2112", 0,
                 Senses::kSight,
                 seeing<emulator::SickColaEmulator, emulator::SickColaEmulatorSettings>},
    EmulatorInfo{"sick-cola-a", "SICK LMS111, CoLa A", "LadarSickLms100", "tcp:127.0.0.1:2112", 0,
                 Senses::kSight, make_cola_ascii},
    EmulatorInfo{"sick-picoscan", "SICK picoScan100", "LadarSickPicoScan",
                 "udp:127.0.0.1:2115?local=0", 0, Senses::kSight,
                 seeing<emulator::SickCompactEmulator, emulator::SickCompactEmulatorSettings>},
    EmulatorInfo{"sick-s300", "SICK S300", "LadarSickS", "pty:/tmp/s300", 500000, Senses::kSight,
                 seeing<emulator::SickSEmulator, emulator::SickSEmulatorSettings>},
    EmulatorInfo{"sick-s3000", "SICK S3000", "LadarSickS", "pty:/tmp/s3000", 500000, Senses::kSight,
                 make_s3000},
    EmulatorInfo{"cmps03", "Devantech CMPS03 behind its board", "CompassCmps03", "pty:/tmp/cmps03",
                 57600, Senses::kHeading, make_cmps03},
    EmulatorInfo{"dcf77-emc", "Gude EMC Professional", "ClockDcf77EmcPro", "pty:/tmp/dcf77-emc",
                 9600, Senses::kNothing, make<emulator::EmcProEmulator>},
    EmulatorInfo{"dcf77-mbg", "Meinberg C51", "ClockDcf77MbgC51", "pty:/tmp/dcf77-mbg", 9600,
                 Senses::kNothing, make<emulator::Dcf77Emulator>},
    EmulatorInfo{"nmea", "NMEA 0183 receiver", "GpsNmea", "pty:/tmp/nmea", 4800, Senses::kCourse,
                 make_nmea},
    EmulatorInfo{"ublox", "u-blox M9", "GpsUblox", "pty:/tmp/ublox", 38400, Senses::kCourse,
                 make_ublox},
    EmulatorInfo{"ublox-m8", "u-blox M8", "GpsUblox", "pty:/tmp/ublox-m8", 9600, Senses::kCourse,
                 make_ublox_m8},
    EmulatorInfo{"xsens", "Xsens MTi-300 (MTData2)", "GyroXsens", "pty:/tmp/xsens", 115200,
                 Senses::kInertia, make_xsens},
    EmulatorInfo{"xsens-mtx", "Xsens MTx (MTData)", "GyroXsens", "pty:/tmp/xsens-mtx", 115200,
                 Senses::kInertia, make_xsens_mtx},
    EmulatorInfo{"echo", "returns received bytes", "timsctl device record", "pty:/tmp/echo", 115200,
                 Senses::kNothing, make<Echo>},
    EmulatorInfo{"firmata", "Arduino UNO with Firmata", "Io", "pty:/tmp/firmata", 57600,
                 Senses::kNothing, make<emulator::IoBoard>},
    EmulatorInfo{"ouster", "Ouster OS-0-16", "Scan3dOuster", "udp:127.0.0.1:7502?local=0", 0,
                 Senses::kSight, spinning<emulator::OusterScanner>},
    EmulatorInfo{"ouster-page", "metadata server of an Ouster", "Scan3dOuster --scanner",
                 "tcp:127.0.0.1:8075", 0, Senses::kNothing, make<emulator::OusterPage>},
    EmulatorInfo{"velodyne", "Velodyne VLP-16", "Scan3dVelodyne", "udp:127.0.0.1:2368?local=0", 0,
                 Senses::kSight, spinning<emulator::VelodyneScanner>},
    EmulatorInfo{"ip-camera", "camera that sends motion JPEG by HTTP", "CameraV4l",
                 "tcp:127.0.0.1:8091", 0, Senses::kPictures, make_ip_camera},
    EmulatorInfo{"visca", "camera mount with VISCA", "PtzDrive", "pty:/tmp/visca", 9600,
                 Senses::kNothing, make<emulator::PtzCamera>},
    EmulatorInfo{"visca-ip", "camera mount with VISCA over IP", "PtzDrive", "udp::52381", 0,
                 Senses::kNothing, make_ptz_camera_over_ip},
    EmulatorInfo{"pioneer", "Pioneer, by P2OS", "ChassisPioneer", "pty:/tmp/pioneer", 9600,
                 Senses::kWheels, make<PioneerEmulator>},
    EmulatorInfo{"roomba", "iRobot Roomba 400", "ChassisRoomba", "pty:/tmp/roomba", 57600,
                 Senses::kWheels, make_roomba},
    EmulatorInfo{"create2", "iRobot Create 2", "ChassisRoomba --model=1", "pty:/tmp/create2",
                 115200, Senses::kWheels, make_create2},
    EmulatorInfo{"er1", "Evolution Robotics ER1", "ChassisEr1", "pty:/tmp/er1", 250000,
                 Senses::kWheels, make<Er1Emulator>},
    EmulatorInfo{"odrives", "two ODrives, nodes 1 and 2", "ChassisCan", "can:vcan0", 0,
                 Senses::kWheels, bus<odrive_base>},
    EmulatorInfo{"vescs", "two VESCs, nodes 1 and 2", "ChassisCan --controller=1", "can:vcan0", 0,
                 Senses::kWheels, bus<vesc_base>},
    EmulatorInfo{"cia402", "two CiA 402 drives, nodes 1 and 2", "Chassis402", "can:vcan0", 0,
                 Senses::kWheels, bus<cia402_base>},
    EmulatorInfo{"robucar", "six CiA 402 drives, nodes 1 to 6", "ChassisRobucar", "can:vcan0", 0,
                 Senses::kWheels, bus<robucar>},
    EmulatorInfo{"servo", "a CiA 402 drive, node 1", "ServoDrive", "can:vcan0", 0, Senses::kWheels,
                 bus<servo>},
    EmulatorInfo{"rover", "a rover with MAVLink autopilot", "MavlinkVehicle", "pty:/tmp/rover",
                 57600, Senses::kWheels, make<RoverEmulator>},
};

}  // namespace

std::span<const EmulatorInfo> emulators() { return kEmulators; }

const EmulatorInfo* find_emulator(std::string_view name) {
  const auto* const found = std::ranges::find(kEmulators, name, &EmulatorInfo::name);
  return found == std::end(kEmulators) ? nullptr : found;
}

}  // namespace rack::device
