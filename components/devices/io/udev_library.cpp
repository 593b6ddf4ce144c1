#include "components/devices/io/udev_library.h"

#include <unistd.h>

namespace rack::device {

std::vector<Udev<udev_device>> udev_devices(std::span<const char* const> subsystems) {
  std::vector<Udev<udev_device>> devices;
  const Udev<udev> context(::udev_new());
  const Udev<udev_enumerate> list(context ? ::udev_enumerate_new(context.get()) : nullptr);
  if (!list) return devices;
  for (const char* subsystem : subsystems)
    ::udev_enumerate_add_match_subsystem(list.get(), subsystem);
  ::udev_enumerate_scan_devices(list.get());
  for (udev_list_entry* entry = ::udev_enumerate_get_list_entry(list.get()); entry != nullptr;
       entry = ::udev_list_entry_get_next(entry)) {
    // None if it was unplugged since.
    Udev<udev_device> device(
        ::udev_device_new_from_syspath(context.get(), ::udev_list_entry_get_name(entry)));
    if (device) devices.push_back(std::move(device));
  }
  return devices;
}

// udev's library looks there, too.
bool has_udevd() { return ::access("/run/udev/control", F_OK) == 0; }

}  // namespace rack::device
