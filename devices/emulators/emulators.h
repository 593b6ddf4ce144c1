// All emulators, by name.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "devices/core/dialogue.h"

namespace rack::device {

struct EmulatorInfo {
  std::string_view name;     // "lms200"
  std::string_view device;   // for people
  std::string_view driver;   // the program that speaks with it
  std::string_view address;  // as in "pty:/tmp/lms"
  std::uint32_t baud;        // of its line when it is switched on; 0: it has none
  std::unique_ptr<Dialogue> (*make)();
};

std::span<const EmulatorInfo> emulators();
// Or none.
const EmulatorInfo* find_emulator(std::string_view name);

}  // namespace rack::device
