// Where the front of a SICK scanner is on its scale of angles. Most scanners count from their
// right, so that the front is at 90 degrees; some count from the front, or clockwise.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace rack::device {

struct ColaFront {
  double degrees = 90;
  bool is_clockwise = false;  // angles increase to the right

  bool operator==(const ColaFront&) const = default;
};

// By the scanner's name of DeviceIdent; empty if its family is not known to differ.
std::optional<ColaFront> front_of_name(std::string_view name);

// For recordings without a name, by the first angle of a scan [1/10000 degree].
ColaFront front_of_range(std::int32_t start_angle);

}  // namespace rack::device
