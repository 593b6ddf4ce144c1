// All emulators, by name.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "components/devices/core/scene.h"

namespace rack::device {

// The environment of an emulator, which replaces its default scene; each emulator uses only the
// members it needs.
struct Scene {
  emulator::Sight sight{};
  emulator::Course course{};
  emulator::Inertia inertia{};
  emulator::Heading heading{};
  std::shared_ptr<emulator::PictureSource> pictures{};
  Duration
      period{};  // period of fixes of a receiver that its driver does not configure; 0: default
};

// The member of the scene that an emulator uses. kWheels: the emulator is a Wheelwork.
enum class Senses : std::uint8_t {
  kNothing,
  kSight,
  kCourse,
  kInertia,
  kHeading,
  kWheels,
  kPictures
};

struct EmulatorInfo {
  std::string_view name;     // "lms200"
  std::string_view device;   // description for users
  std::string_view driver;   // driver program of the device
  std::string_view address;  // default address, for example "pty:/tmp/lms"
  std::uint32_t baud;        // rate of its line at power-on; 0: no rate
  Senses senses;
  std::unique_ptr<Dialogue> (*make)(const Scene& scene);
};

std::span<const EmulatorInfo> emulators();
// Returns null for unknown names.
const EmulatorInfo* find_emulator(std::string_view name);

}  // namespace rack::device
