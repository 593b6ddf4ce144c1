#include "devices/emulators/emulators.h"

#include <algorithm>
#include <array>

#include "devices/emulators/lms200_emulator.h"

namespace rack::device {
namespace {

template <class Emulator>
std::unique_ptr<Dialogue> make() {
  return std::make_unique<Emulator>();
}

constexpr std::array kEmulators = {
    EmulatorInfo{"lms200", "SICK LMS200", "LadarSickLms200", "pty:/tmp/lms200", 9600,
                 make<Lms200Emulator>},
};

}  // namespace

std::span<const EmulatorInfo> emulators() { return kEmulators; }

const EmulatorInfo* find_emulator(std::string_view name) {
  const auto* const found = std::ranges::find(kEmulators, name, &EmulatorInfo::name);
  return found == kEmulators.end() ? nullptr : found;
}

}  // namespace rack::device
