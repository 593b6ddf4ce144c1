// The udev rules that give devices stable names and grant access, generated from the list of known
// devices.
#pragma once

#include <string>

namespace rack::device {

// The text of deploy/udev/60-rack.rules.
std::string udev_rules();

}  // namespace rack::device
