// What is plugged into this host, as the kernel shows it in /sys and /dev.
#pragma once

#include <string>
#include <vector>

#include "components/devices/known/host_device.h"
#include "os/file.h"
#include "tims/result.h"

namespace rack::device {

// `root`: where /sys, /dev and /proc are, for tests.
std::vector<HostDevice> host_devices(const std::string& root = {});

// Can be read when something was plugged in or pulled out; take_device_events() empties it. udev
// needs some time after that for its links. Not every container hears of it: look again by the
// clock as well.
tims::Result<tims::os::File> listen_for_devices();
void take_device_events(const tims::os::File& events);

}  // namespace rack::device
