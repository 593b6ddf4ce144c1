#include "devices/emulators/emulators.h"

#include <algorithm>
#include <array>

#include "devices/emulators/hokuyo_emulator.h"
#include "devices/emulators/ibeo_emulator.h"
#include "devices/emulators/ibeo_lux_emulator.h"
#include "devices/emulators/ld19_emulator.h"
#include "devices/emulators/rplidar_emulator.h"

namespace rack::device {
namespace {

template <class Emulator>
std::unique_ptr<Dialogue> make() {
  return std::make_unique<Emulator>();
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
};

}  // namespace

std::span<const EmulatorInfo> emulators() { return kEmulators; }

const EmulatorInfo* find_emulator(std::string_view name) {
  const auto* const found = std::ranges::find(kEmulators, name, &EmulatorInfo::name);
  return found == kEmulators.end() ? nullptr : found;
}

}  // namespace rack::device
