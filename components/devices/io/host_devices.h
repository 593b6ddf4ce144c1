// The devices plugged into this host, according to /sys and /dev.
#pragma once

#include <string>
#include <vector>

#include "components/devices/known/host_device.h"
#include "os/file.h"
#include "tims/result.h"

namespace rack::device {

// `root`: directory that contains sys, dev and proc, for tests.
std::vector<HostDevice> host_devices(const std::string& root = {});

// A descriptor that becomes readable when a device was plugged in or unplugged;
// take_device_events() drains it. udev creates its links some time later. Some containers receive
// no such events: also poll host_devices() periodically.
tims::Result<tims::os::File> listen_for_devices();
void take_device_events(const tims::os::File& events);

}  // namespace rack::device
