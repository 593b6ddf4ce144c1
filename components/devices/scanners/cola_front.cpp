#include "components/devices/scanners/cola_front.h"

#include <algorithm>
#include <array>

namespace rack::device {
namespace {

struct NamedFront {
  std::string_view name;  // beginning, in capitals; ? is any character
  ColaFront front;
};

// As the manufacturer's driver for ROS has them (SICKAG/sick_scan_xd, sick_generic_parser.cpp).
constexpr std::array<NamedFront, 9> kNamedFronts = {{
    {"TIM24", {.degrees = 0}},
    {"LRS4", {.degrees = 0}},
    {"NAV2", {.degrees = 0}},
    {"NAV35", {.degrees = 180}},
    {"NAV3", {.degrees = 180, .is_clockwise = true}},
    {"LRS36?1", {.degrees = 180}},
    {"LRS36", {.degrees = 180, .is_clockwise = true}},
    {"OEM15", {.degrees = 180, .is_clockwise = true}},
    {"OEM-15", {.degrees = 180, .is_clockwise = true}},
}};

char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

bool begins_with(std::string_view name, std::string_view beginning) {
  return name.size() >= beginning.size() &&
         std::ranges::equal(beginning, name.substr(0, beginning.size()), [](char wanted, char c) {
           return wanted == '?' || wanted == capital(c);
         });
}

}  // namespace

std::optional<ColaFront> front_of_name(std::string_view name) {
  for (const NamedFront& known : kNamedFronts)
    if (begins_with(name, known.name)) return known.front;
  return std::nullopt;
}

// Scanners that count from their right see at most 55 degrees behind it. A scan that begins further
// behind is of one that counts from its front.
ColaFront front_of_range(std::int32_t start_angle) {
  constexpr std::int32_t kFurthest = -600000;
  return start_angle < kFurthest ? ColaFront{.degrees = 0} : ColaFront{};
}

}  // namespace rack::device
