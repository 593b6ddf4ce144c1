// The devices of this host as udev knows them, and the list for users that follows from them. A
// device of the kernel is often several of udev's: a converter is a USB device with an interface, a
// port of the converter, and a terminal. Pure: components/devices/io/host_devices.h reads them.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "components/devices/known/host_device.h"

namespace rack::device {

struct UdevDevice {
  using Table = std::map<std::string, std::string, std::less<>>;

  std::string path{};    // in /sys; identifies the device
  std::string parent{};  // path of the device above; empty: none
  std::string usb{};     // path of the USB device that contains it; empty: none
  // Only those of the kernel are used (SUBSYSTEM, DEVTYPE, DEVNAME, DRIVER): containers without
  // udevd have no others.
  Table properties{};
  Table attributes{};                // files in /sys: those of udev_attributes()
  std::vector<std::string> links{};  // to its device file
  bool has_file = false;             // the device file exists
};

// The attributes that the list needs from devices of a subsystem.
std::span<const char* const> udev_attributes(std::string_view subsystem);

// The subsystems whose devices are listed, in the order of the list.
std::span<const char* const> udev_subsystems();

// `all`: the devices of udev_subsystems(), and their parents. Permissions and users of the device
// files are not known here.
std::vector<HostDevice> listed_devices(std::span<const UdevDevice> all);

}  // namespace rack::device
