// All emulators, by name.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "components/devices/core/scene.h"

namespace rack::device {

// What there is for it to sense, instead of what it has of its own; only what it needs is looked
// at.
struct Scene {
  emulator::Sight sight{};
  emulator::Course course{};
  emulator::Inertia inertia{};
  emulator::Heading heading{};
  Duration period{};  // between fixes of a receiver that nobody tells; 0: its own
};

// What an emulator takes of its surroundings. Of a base: it is a Wheelwork.
enum class Senses : std::uint8_t { kNothing, kSight, kCourse, kInertia, kHeading, kWheels };

struct EmulatorInfo {
  std::string_view name;     // "lms200"
  std::string_view device;   // for people
  std::string_view driver;   // the program that speaks with it
  std::string_view address;  // as in "pty:/tmp/lms"
  std::uint32_t baud;        // of its line when it is switched on; 0: it has none
  Senses senses;
  std::unique_ptr<Dialogue> (*make)(const Scene& scene);
};

std::span<const EmulatorInfo> emulators();
// Or none.
const EmulatorInfo* find_emulator(std::string_view name);

}  // namespace rack::device
