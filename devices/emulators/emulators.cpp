#include "devices/emulators/emulators.h"

#include <algorithm>

#include "devices/camera/ptz_camera.h"
#include "devices/chassis/er1_robot.h"
#include "devices/chassis/motor_bus.h"
#include "devices/chassis/pioneer.h"
#include "devices/chassis/roomba_robot.h"
#include "devices/chassis/rover.h"
#include "devices/navigation/cmps03_emulator.h"
#include "devices/navigation/dcf77_emulator.h"
#include "devices/navigation/nmea_emulator.h"
#include "devices/navigation/ublox_emulator.h"
#include "devices/navigation/xsens_emulator.h"
#include "devices/pins/io_board.h"
#include "devices/scan3d/spinning_scanner.h"
#include "devices/scanners/hokuyo_emulator.h"
#include "devices/scanners/ibeo_emulator.h"
#include "devices/scanners/ibeo_lux_emulator.h"
#include "devices/scanners/ld19_emulator.h"
#include "devices/scanners/lms200_emulator.h"
#include "devices/scanners/rplidar_emulator.h"
#include "devices/scanners/sick_cola_emulator.h"
#include "devices/scanners/sick_compact_emulator.h"
#include "devices/scanners/sick_s_emulator.h"

namespace rack::device {
namespace {

// A device that says what it hears: to try a line with, and `timsctl device record`.
class Echo final : public Dialogue {
 public:
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output& out) override {
    out.send(arrival.bytes, arrival.id);
  }
};

template <class Emulator>
std::unique_ptr<Dialogue> make() {
  return std::make_unique<Emulator>();
}

std::unique_ptr<Dialogue> make_cola_ascii() {
  return std::make_unique<emulator::SickColaEmulator>(
      emulator::SickColaEmulatorSettings{.dialect = ColaDialect::kAscii});
}
std::unique_ptr<Dialogue> make_s3000() {
  return std::make_unique<emulator::SickSEmulator>(
      emulator::SickSEmulatorSettings{.device = SickSDevice::kS3000});
}

std::unique_ptr<Dialogue> make_roomba() {
  return std::make_unique<RoombaEmulator>(RoombaModel::kRoomba);
}
std::unique_ptr<Dialogue> make_create2() {
  return std::make_unique<RoombaEmulator>(RoombaModel::kCreate2);
}
std::unique_ptr<Dialogue> make_ptz_camera_over_ip() {
  return std::make_unique<emulator::PtzCamera>(true);
}

constexpr EmulatorInfo kEmulators[] = {
    EmulatorInfo{"hokuyo", "Hokuyo URG-04LX", "LadarHokuyoUrg", "pty:/tmp/hokuyo", 19200,
                 make<emulator::Hokuyo>},
    EmulatorInfo{"ibeo", "Ibeo LD-A", "LadarIbeo", "can:vcan0", 0, make<emulator::Ibeo>},
    EmulatorInfo{"ibeo-lux", "Ibeo Lux", "LadarIbeoLux", "tcp:127.0.0.1:12002", 0,
                 make<emulator::IbeoLux>},
    EmulatorInfo{"ld19", "LDROBOT LD19", "LadarRplidar", "pty:/tmp/ld19", 230400,
                 make<emulator::Ld19>},
    EmulatorInfo{"rplidar", "Slamtec RPLIDAR A1", "LadarRplidar", "pty:/tmp/rplidar", 115200,
                 make<emulator::Rplidar>},
    EmulatorInfo{"lms200", "SICK LMS200", "LadarSickLms200", "pty:/tmp/lms200", 9600,
                 make<emulator::Lms200Emulator>},
    EmulatorInfo{"sick-cola", "SICK LMS111, CoLa B", "LadarSickCola", "tcp:127.0.0.1:2112", 0,
                 make<emulator::SickColaEmulator>},
    EmulatorInfo{"sick-cola-a", "SICK LMS111, CoLa A", "LadarSickLms100", "tcp:127.0.0.1:2112", 0,
                 make_cola_ascii},
    EmulatorInfo{"sick-picoscan", "SICK picoScan100", "LadarSickPicoScan",
                 "udp:127.0.0.1:2115?local=0", 0, make<emulator::SickCompactEmulator>},
    EmulatorInfo{"sick-s300", "SICK S300", "LadarSickS", "pty:/tmp/s300", 500000,
                 make<emulator::SickSEmulator>},
    EmulatorInfo{"sick-s3000", "SICK S3000", "LadarSickS", "pty:/tmp/s3000", 500000, make_s3000},
    EmulatorInfo{"cmps03", "Devantech CMPS03 behind its board", "CompassCmps03", "pty:/tmp/cmps03",
                 57600, make<emulator::Cmps03Emulator>},
    EmulatorInfo{"dcf77-emc", "Gude EMC Professional", "ClockDcf77EmcPro", "pty:/tmp/dcf77-emc",
                 9600, make<emulator::EmcProEmulator>},
    EmulatorInfo{"dcf77-mbg", "Meinberg C51", "ClockDcf77MbgC51", "pty:/tmp/dcf77-mbg", 9600,
                 make<emulator::Dcf77Emulator>},
    EmulatorInfo{"nmea", "NMEA 0183 receiver", "GpsNmea", "pty:/tmp/nmea", 4800,
                 make<emulator::NmeaEmulator>},
    EmulatorInfo{"ublox", "u-blox M9", "GpsUblox", "pty:/tmp/ublox", 38400,
                 make<emulator::UbloxEmulator>},
    EmulatorInfo{"ublox-m8", "u-blox M8", "GpsUblox", "pty:/tmp/ublox-m8", 9600,
                 make<emulator::UbloxM8Emulator>},
    EmulatorInfo{"xsens", "Xsens MTi-300 (MTData2)", "GyroXsens", "pty:/tmp/xsens", 115200,
                 make<emulator::XsensEmulator>},
    EmulatorInfo{"xsens-mtx", "Xsens MTx (MTData)", "GyroXsens", "pty:/tmp/xsens-mtx", 115200,
                 make<emulator::XsensOldEmulator>},
    EmulatorInfo{"echo", "says what it hears", "timsctl device record", "pty:/tmp/echo", 115200,
                 make<Echo>},
    EmulatorInfo{"firmata", "Arduino UNO with Firmata", "Io", "pty:/tmp/firmata", 57600,
                 make<emulator::IoBoard>},
    EmulatorInfo{"ouster", "Ouster OS-0-16", "Scan3dOuster", "udp:127.0.0.1:7502?local=0", 0,
                 make<emulator::OusterScanner>},
    EmulatorInfo{"ouster-page", "what an Ouster says of itself", "Scan3dOuster --scanner",
                 "tcp:127.0.0.1:8075", 0, make<emulator::OusterPage>},
    EmulatorInfo{"velodyne", "Velodyne VLP-16", "Scan3dVelodyne", "udp:127.0.0.1:2368?local=0", 0,
                 make<emulator::VelodyneScanner>},
    EmulatorInfo{"visca", "camera mount with VISCA", "PtzDrive", "pty:/tmp/visca", 9600,
                 make<emulator::PtzCamera>},
    EmulatorInfo{"visca-ip", "camera mount with VISCA over IP", "PtzDrive", "udp::52381", 0,
                 make_ptz_camera_over_ip},
    EmulatorInfo{"pioneer", "Pioneer, by P2OS", "ChassisPioneer", "pty:/tmp/pioneer", 9600,
                 make<PioneerEmulator>},
    EmulatorInfo{"roomba", "iRobot Roomba 400", "ChassisRoomba", "pty:/tmp/roomba", 57600,
                 make_roomba},
    EmulatorInfo{"create2", "iRobot Create 2", "ChassisRoomba --model=1", "pty:/tmp/create2",
                 115200, make_create2},
    EmulatorInfo{"er1", "Evolution Robotics ER1", "ChassisEr1", "pty:/tmp/er1", 250000,
                 make<Er1Emulator>},
    EmulatorInfo{"odrives", "two ODrives, nodes 1 and 2", "ChassisCan", "can:vcan0", 0,
                 odrive_base},
    EmulatorInfo{"vescs", "two VESCs, nodes 1 and 2", "ChassisCan --controller=1", "can:vcan0", 0,
                 vesc_base},
    EmulatorInfo{"cia402", "two CiA 402 drives, nodes 1 and 2", "Chassis402", "can:vcan0", 0,
                 cia402_base},
    EmulatorInfo{"robucar", "six CiA 402 drives, nodes 1 to 6", "ChassisRobucar", "can:vcan0", 0,
                 robucar},
    EmulatorInfo{"servo", "a CiA 402 drive, node 1", "ServoDrive", "can:vcan0", 0, servo},
    EmulatorInfo{"rover", "a rover with MAVLink autopilot", "MavlinkVehicle", "pty:/tmp/rover",
                 57600, make<RoverEmulator>},
};

}  // namespace

std::span<const EmulatorInfo> emulators() { return kEmulators; }

const EmulatorInfo* find_emulator(std::string_view name) {
  const auto* const found = std::ranges::find(kEmulators, name, &EmulatorInfo::name);
  return found == std::end(kEmulators) ? nullptr : found;
}

}  // namespace rack::device
