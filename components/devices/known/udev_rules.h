// The rules that give devices stable names and programs their rights, as a text for udev: made from
// the list of known devices.
#pragma once

#include <string>

namespace rack::device {

// deploy/udev/60-rack.rules
std::string udev_rules();

}  // namespace rack::device
