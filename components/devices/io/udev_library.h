// What udev's library hands out, with owners.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <libudev.h>

namespace rack::device {

struct UdevUnref {
  void operator()(udev* context) const { ::udev_unref(context); }
  void operator()(udev_device* device) const { ::udev_device_unref(device); }
  void operator()(udev_enumerate* list) const { ::udev_enumerate_unref(list); }
  void operator()(udev_monitor* monitor) const { ::udev_monitor_unref(monitor); }
};
template <typename T>
using Udev = std::unique_ptr<T, UdevUnref>;

// The devices of some subsystems, with and without an entry in udev's database.
std::vector<Udev<udev_device>> udev_devices(std::span<const char* const> subsystems);

// Whether udevd runs. Containers have none: then devices have only the properties of the kernel,
// and only the kernel reports changes.
bool has_udevd();

}  // namespace rack::device
