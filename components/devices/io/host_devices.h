// The devices plugged into this host, according to udev.
#pragma once

#include <vector>

#include "components/devices/known/host_device.h"

namespace rack::device {

// udev's library is asked in one place; what the list makes of its answers is listed_devices().
std::vector<HostDevice> host_devices();

}  // namespace rack::device
