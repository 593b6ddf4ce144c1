#include "devices/emulators/emulators.h"

#include <algorithm>
#include <array>

#include "devices/emulators/hokuyo_emulator.h"
#include "devices/emulators/ibeo_emulator.h"
#include "devices/emulators/ibeo_lux_emulator.h"
#include "devices/emulators/ld19_emulator.h"
#include "devices/emulators/rplidar_emulator.h"
#include "devices/emulators/lms200_emulator.h"
#include "devices/emulators/sick_cola_emulator.h"
#include "devices/emulators/sick_compact_emulator.h"
#include "devices/emulators/sick_s_emulator.h"

namespace rack::device {
namespace {

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

constexpr std::array kEmulators = {
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
};

}  // namespace

std::span<const EmulatorInfo> emulators() { return kEmulators; }

const EmulatorInfo* find_emulator(std::string_view name) {
  const auto* const found = std::ranges::find(kEmulators, name, &EmulatorInfo::name);
  return found == kEmulators.end() ? nullptr : found;
}

}  // namespace rack::device
